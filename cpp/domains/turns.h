// A curve through an octree, as a table of turns: in which order it visits the eight parts of a cell, and how it turns
// inside each of them.
#pragma once

#include <array>
#include <cstdint>

namespace motes::domains {

/// One part of a cell: its place among the eight along the curve, and the curve's state inside it.
struct CurveStep {
  std::uint8_t place = 0;
  std::uint8_t next = 0;
};

/// The turns of a state, by part of a cell. Bit 0 of a part's number: the upper half along x; bit 1: y; bit 2: z.
using Turns = std::array<CurveStep, 8>;

}  // namespace motes::domains
