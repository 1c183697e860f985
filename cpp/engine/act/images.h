// Images: in periodic space a particle is also where it would be a period farther on, along each periodic axis. What is
// near one end of space sees the images of what is near the other end: ghosts with the ids of their originals, also on
// the calculator that owns these.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "domains/domains.h"
#include "particles/periods.h"

namespace motes::engine {

/// The places where particles are, by number: 0 is the particle itself, then its images, 26 at most.
class Images {
 public:
  explicit Images(const particles::Periods& periods);

  std::uint8_t count() const { return static_cast<std::uint8_t>(shifts_.size()); }
  bool any() const { return shifts_.size() > 1; }

  /// Returns where place `number` of a particle at x is along an axis, m: the same bits on every calculator.
  float at(std::uint8_t number, std::size_t axis, float x) const {
    return static_cast<float>(static_cast<double>(x) + shifts_[number][axis]);
  }

  /// Returns the largest distance of an end of space from the origin, m; 0 where it has none.
  float farthest_end() const;

  /// Returns the part of a domain that particles can be in: along periodic axes it ends where space does.
  domains::BoxCover ends(domains::BoxCover cover) const;

  /// Tells whether two parts of space are at most so far from each other, m, at any of their places.
  bool within(const domains::BoxCover& a, const domains::BoxCover& b, double range) const;
  /// Returns the distance of a point from a part of space, m: of any of its places.
  double outside(const domains::BoxCover& cover, const float (&x)[3]) const;

  /// Returns the thickest skin, m, with which no list has two places of one particle: what the pair remembers would
  /// then stay at one of them until the list is made anew. `reach`: how far the action sees, m.
  float most_skin(float reach) const;

  /// Throws std::invalid_argument for an action that a particle would see another one's image with, besides itself, or
  /// that knows no images. `reach`: how far it sees, m.
  void check(const actions::Action& action, float reach) const;

 private:
  particles::Periods periods_;
  std::vector<std::array<double, 3>> shifts_;  // metres
};

}  // namespace motes::engine
