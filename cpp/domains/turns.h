// A curve through an octree, as a table of turns: which of the eight parts of a cell it visits first, second, ..., and
// how it turns inside each of them.
#pragma once

#include <array>
#include <cstdint>

namespace motes::domains {

/// Of one part of a cell: its place among the eight along the curve, and the state in which the curve is inside it.
struct CurveStep {
  std::uint8_t place = 0;
  std::uint8_t next = 0;
};

/// By the parts of a cell. Bit 0 of their number: the upper half along x; bit 1: y; bit 2: z.
using Turns = std::array<CurveStep, 8>;

}  // namespace motes::domains
