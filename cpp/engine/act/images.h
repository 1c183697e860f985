// Images: in periodic space, each particle has copies shifted by a period along each periodic axis. Particles near one
// end of space see the images of particles near the other end. Images are ghosts with the ids of their originals, even
// on the calculator that owns the originals.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "domains/domains.h"
#include "interactions/pair_action.h"
#include "particles/periods.h"

namespace motes::engine {

/// The places of particles, by number: 0 is the particle itself, followed by its images, at most 26.
class Images {
 public:
  explicit Images(const particles::Periods& periods);

  std::uint8_t count() const { return static_cast<std::uint8_t>(shifts_.size()); }
  bool any() const { return shifts_.size() > 1; }

  /// Returns the coordinate of place `number` of a particle at x along an axis, m; the same bits on every calculator.
  float at(std::uint8_t number, std::size_t axis, float x) const {
    return static_cast<float>(static_cast<double>(x) + shifts_[number][axis]);
  }

  /// Returns the largest distance of an end of periodic space from the origin, m; 0 if no axis is periodic.
  float farthest_end() const;

  /// Returns the part of a domain that particles can be in: clipped to space along periodic axes.
  domains::BoxCover ends(domains::BoxCover cover) const;

  /// Returns whether two parts of space, at any of their places, are at most `range` metres apart.
  bool within(const domains::BoxCover& a, const domains::BoxCover& b, double range) const;
  /// Returns the smallest distance of any place of a point from a part of space, m.
  double outside(const domains::BoxCover& cover, const float (&x)[3]) const;

  /// Returns the thickest skin, m, with which a neighbour list pairs a particle with only one place of another. With
  /// two places, the pair's memory would stay with one of them until the list is rebuilt. `reach`: reach of the action,
  /// m.
  float most_skin(float reach) const;

  /// Throws std::invalid_argument if the action does not support images, or if its reach is over half a period, so a
  /// particle could see both another particle and its image. `reach`: metres.
  void check(const interactions::PairAction& action, float reach) const;

 private:
  particles::Periods periods_;
  std::vector<std::array<double, 3>> shifts_;  // metres
};

}  // namespace motes::engine
