// Boxes of domains, and places in them.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "domains/space.h"

namespace motes::domains_test {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

using Place = std::array<float, 3>;

inline bool holds(const domains::Box& box, const Place& p) {
  bool inside = true;
  for (std::size_t axis = 0; axis < 3; ++axis) inside = inside && p[axis] >= box.low[axis] && p[axis] < box.high[axis];
  return inside;
}

}  // namespace motes::domains_test
