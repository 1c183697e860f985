// Ownership: which calculator owns a particle, for one system (paper 3.1.4). Domains are slabs along one axis, bricks
// made by halving space along two or three, or stretches of a curve; or the particles are distributed by id.
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

/// Returns the coordinate, 0 <= s < 1, that replaces x where particles are distributed by id: multiples of the golden
/// ratio, modulo 1. Any run of consecutive ids fills the interval evenly.
inline float scattered(std::uint64_t id) { return static_cast<float>((id * 0x9E3779B97F4A7C15u) >> 40) * 0x1p-24f; }

/// A cut: x < at is on its left, everything else, including NaN, on its right.
struct Cut {
  std::int32_t axis = 0;  // 0..2: x, y, z; kById, kMorton, kHilbert
  float at = 0;           // metres

  bool operator==(const Cut&) const = default;
};
static_assert(sizeof(Cut) == 8);  // its size in messages

template <class Visitor>
constexpr void fields(Visitor& visit, Cut& cut) {
  visit(cut.axis, cut.at);
}

/// Returns how many of n domains are to the left of the cut that halves them. It is cut number n / 2 - 1, so cut i is
/// between domains i and i + 1, whatever the axes.
constexpr int left_part(int domains) { return domains / 2; }

/// The n domains of one system: a tree of n - 1 cuts. If all have the same axis, domains are slabs and the cuts ascend:
/// domain i holds cuts[i-1] <= x < cuts[i]. Outer faces are at infinity. A NaN coordinate is beyond every cut of its
/// axis, so the last slab owns it.
class Domains {
 public:
  /// One domain that holds everything.
  Domains() = default;
  /// Slabs along an axis (0..2), or parts of the ids (kById). Throws std::invalid_argument if the cuts do not ascend or
  /// one of them is NaN.
  explicit Domains(std::vector<float> cuts, int axis = 0);
  /// Stretches of a curve, cut at these places along it, 0..1. Throws like the constructor above.
  Domains(std::vector<float> cuts, std::shared_ptr<const Curve> curve);
  /// Returns the domains of any tree, given by its cuts in the order of the domains that they separate. `curve`: the
  /// curve, if one is cut. Throws std::invalid_argument if a cut is outside the part of space that it halves, is NaN,
  /// or has an invalid axis.
  static Domains of(const std::vector<Cut>& tree, std::shared_ptr<const Curve> curve = nullptr);
  /// Returns the same domains with other cuts along the one axis or curve. Throws like the constructors.
  Domains with(std::vector<float> cuts) const;

  int count() const { return static_cast<int>(cuts_.size()) + 1; }
  /// Returns the positions of the cuts, in the order of the domains: ascending for slabs.
  const std::vector<float>& cuts() const { return cuts_; }
  /// Returns the axis of all cuts; -1 if they differ (see tree()).
  int axis() const { return axis_; }
  /// Returns the axis of the cut that halves all of space.
  int halved() const { return axis_ >= 0 ? axis_ : nodes_[static_cast<std::size_t>(left_part(count()))].axis; }
  /// Returns all cuts with their axes.
  std::vector<Cut> tree() const;
  /// Returns the curve that is cut; null if axes or ids are cut.
  const std::shared_ptr<const Curve>& curve() const { return curve_; }
  /// Returns the largest distance of a face between two domains from the origin, along the axis that it cuts, m.
  float farthest_face() const;

  /// Returns the owner of a particle. This is the single rule of ownership: births, exchange, reads and donation all
  /// use it.
  int owner_of(const std::array<float, 3>& position, std::uint64_t id) const {
    const std::uint32_t lower = particles::lower_half(id), upper = particles::upper_half(id);
    std::uint32_t owner = 0;
    owners_of({{position.data(), &position[1], &position[2]}, {&lower, &upper}, 1}, &owner);
    return static_cast<int>(owner);
  }
  /// Write the owners of all particles, or of particles first .. last - 1, to owners[] at the particles' numbers.
  void owners_of(const Places& places, std::uint32_t* owners) const { owners_of(places, 0, places.count, owners); }
  void owners_of(const Places& places, std::size_t first, std::size_t last, std::uint32_t* owners) const;

  /// Returns the part of space that belongs to a slab or brick: a particle belongs to it exactly if its position is in
  /// the box. All of space if ids or a curve are cut.
  Box box(int domain) const;
  /// Returns boxes around everything that belongs to a domain.
  BoxCover cover(int domain) const;

  // Return the ends of a domain along the one axis of its cuts, among the ids, or along the curve.
  float low(int domain) const;   // -infinity for the first
  float high(int domain) const;  // infinity for the last

  bool operator==(const Domains& other) const;

 private:
  void search(std::span<const float> x, std::uint32_t* owners) const;
  void look_up(const Places& places, std::size_t first, std::size_t count, std::uint32_t* owners) const;
  void walk(const Places& places, std::size_t first, std::size_t count, std::uint32_t* owners) const;

  std::vector<float> cuts_;
  std::vector<Cut> nodes_;  // if axes differ: node i is cut i - 1; node 0 is a placeholder
  int axis_ = 0;
  std::shared_ptr<const Curve> curve_;
  std::vector<std::uint32_t> of_blocks_;  // owners of the curve's blocks
};

}  // namespace motes::domains
