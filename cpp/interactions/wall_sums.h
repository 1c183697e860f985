// Forces on walls, as sums that depend neither on the order of touches nor on the ranks that compute them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "particles/exact_sum.h"

namespace motes::interactions {

/// The sum of the forces, N, of particles on a wall, and of their torques about the wall's origin, N m.
struct WallSum {
  particles::ExactSum force[3], torque[3];

  WallSum& operator+=(const WallSum& other) {
    for (std::size_t c = 0; c < 3; ++c) {
      force[c] += other.force[c];
      torque[c] += other.torque[c];
    }
    return *this;
  }
  bool operator==(const WallSum&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, WallSum& sum) {
  visit(sum.force, sum.torque);
}

/// The walls of one contact that particles touch, by number.
using WallSums = std::map<std::uint32_t, WallSum>;

}  // namespace motes::interactions
