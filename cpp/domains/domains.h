// Where a particle belongs: which calculator owns it, for one system (paper 3.1.4). Domains are slabs along one axis,
// bricks made by halving space along two or three, or stretches of a curve; or the particles are dealt out by id.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "domains/axes.h"
#include "domains/curve.h"
#include "domains/space.h"
#include "particles/ids.h"

namespace motes::domains {

/// The coordinate, 0 <= s < 1, that takes the place of x where particles are dealt out by id: multiples of the golden
/// ratio, modulo 1. Any run of consecutive ids fills the interval evenly.
inline float scattered(std::uint64_t id) { return static_cast<float>((id * 0x9E3779B97F4A7C15u) >> 40) * 0x1p-24f; }

/// A cut: what is at x < at lies on its left, everything else on its right, NaN too.
struct Cut {
  std::int32_t axis = 0;  // 0..2: x, y, z; kById, kMorton, kHilbert
  float at = 0;           // metres

  bool operator==(const Cut&) const = default;
};
static_assert(sizeof(Cut) == 8);  // as it travels

template <class Visitor>
constexpr void fields(Visitor& visit, Cut& cut) {
  visit(cut.axis, cut.at);
}

/// Where n domains are halved: the first n / 2 of them lie to the left of the cut, which is number n / 2 - 1 of the n
/// - 1. Cut i so stands between domains i and i + 1 in their order, whatever the axes.
constexpr int left_part(int domains) { return domains / 2; }

/// The n domains of one system: a tree of n - 1 cuts. Where all have the same axis, domains are slabs and the cuts
/// ascend: domain i holds cuts[i-1] <= x < cuts[i]. Outer faces are at infinity; a coordinate that is NaN lies beyond
/// every cut of its axis, so slabs give NaN to the last domain.
class Domains {
 public:
  /// One domain that holds everything.
  Domains() = default;
  /// Slabs along an axis (0..2), or parts of the ids (kById). Throws std::invalid_argument where the cuts do not ascend
  /// or one of them is NaN.
  explicit Domains(std::vector<float> cuts, int axis = 0);
  /// Stretches of a curve, cut at these places along it, 0..1. Throws as above.
  Domains(std::vector<float> cuts, std::shared_ptr<const Curve> curve);
  /// Any tree, its cuts in the order of the domains that they stand between; the curve, where that is cut. Throws
  /// std::invalid_argument where a cut lies outside the part of space that it halves, is NaN, or has no such axis.
  static Domains of(const std::vector<Cut>& tree, std::shared_ptr<const Curve> curve = nullptr);
  /// The same with other cuts along the one axis, or curve. Throws as the constructors.
  Domains with(std::vector<float> cuts) const;

  int count() const { return static_cast<int>(cuts_.size()) + 1; }
  /// Positions of the cuts, in the order of the domains: ascending for slabs.
  const std::vector<float>& cuts() const { return cuts_; }
  /// The axis of all cuts, or -1 where they differ: then `tree` says.
  int axis() const { return axis_; }
  /// The axis of the cut that halves all of space.
  int halved() const { return axis_ >= 0 ? axis_ : nodes_[static_cast<std::size_t>(left_part(count()))].axis; }
  /// All cuts with their axes.
  std::vector<Cut> tree() const;
  /// The curve that is cut; null where axes or ids are.
  const std::shared_ptr<const Curve>& curve() const { return curve_; }
  /// The largest distance of a face between two domains from the origin, along the axis that it cuts, m.
  float farthest_face() const;

  /// The single rule of ownership: births, exchange, reads and donation all use it.
  int owner_of(const std::array<float, 3>& position, std::uint64_t id) const {
    const std::uint32_t lower = particles::lower_half(id), upper = particles::upper_half(id);
    std::uint32_t owner = 0;
    owners_of({{position.data(), &position[1], &position[2]}, {&lower, &upper}, 1}, &owner);
    return static_cast<int>(owner);
  }
  /// The same for many particles, or for those from number `first` to `last` - 1, whose owners stand there too.
  void owners_of(const Places& places, std::uint32_t* owners) const { owners_of(places, 0, places.count, owners); }
  void owners_of(const Places& places, std::size_t first, std::size_t last, std::uint32_t* owners) const;

  /// The part of space that belongs to a slab or brick: owner_of gives p to it exactly where p lies in the box. All of
  /// space where ids decide, or a curve.
  Box box(int domain) const;
  /// Boxes around all that belongs to a domain.
  BoxCover cover(int domain) const;

  // The ends of a domain along the one axis of its cuts, among the ids, or along the curve.
  float low(int domain) const;   // -infinity for the first
  float high(int domain) const;  // infinity for the last

  bool operator==(const Domains& other) const;

 private:
  void search(std::span<const float> x, std::uint32_t* owners) const;
  void look_up(const Places& places, std::size_t first, std::size_t count, std::uint32_t* owners) const;
  void walk(const Places& places, std::size_t first, std::size_t count, std::uint32_t* owners) const;

  std::vector<float> cuts_;
  std::vector<Cut> nodes_;  // where axes differ: node i is cut i - 1; node 0 is a stopgap
  int axis_ = 0;
  std::shared_ptr<const Curve> curve_;
  std::vector<std::uint32_t> of_blocks_;  // owners of the curve's blocks
};

}  // namespace motes::domains
