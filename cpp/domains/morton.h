// The Morton curve, or z-order: interleaved bits of x, y and z. It jumps, but never turns.
#pragma once

#include "domains/turns.h"

namespace motes::domains {

/// The only state of the curve.
inline constexpr std::array<Turns, 1> kMortonTurns = [] {
  std::array<Turns, 1> states{};
  for (std::uint8_t part = 0; part < 8; ++part) states[0][part] = {part, 0};
  return states;
}();

}  // namespace motes::domains
