// The Hilbert curve: successive cells have a face in common. For the rules of its turns see C. H. Hamilton and A.
// Rau-Chaplin, "Compact Hilbert indices", Information Processing Letters 105 (2008), for three dimensions.
#pragma once

#include <bit>

#include "domains/turns.h"

namespace motes::domains {

namespace hilbert {

constexpr unsigned gray(unsigned i) { return i ^ i >> 1; }
constexpr unsigned gray_inverse(unsigned g) { return g ^ g >> 1 ^ g >> 2; }
constexpr unsigned rotated_left(unsigned bits, unsigned by) { return (bits << by | bits >> (3 - by)) & 7u; }
constexpr unsigned rotated_right(unsigned bits, unsigned by) { return (bits >> by | bits << (3 - by)) & 7u; }
/// Returns the corner at which the curve enters the i-th part of a cell in its base orientation.
constexpr unsigned entry(unsigned i) { return i == 0 ? 0 : gray((i - 1) / 2 * 2); }
/// Returns the axis along which it passes through that part.
constexpr unsigned direction(unsigned i) {
  if (i == 0) return 0;
  return static_cast<unsigned>(std::countr_one(i % 2 == 0 ? i - 1 : i)) % 3;
}

}  // namespace hilbert

/// A state is three times the corner at which the curve enters a cell, plus the axis along which it passes through.
inline constexpr std::array<Turns, 24> kHilbertTurns = [] {
  std::array<Turns, 24> states{};
  for (unsigned state = 0; state < states.size(); ++state) {
    const unsigned corner = state / 3, axis = state % 3, turn = (axis + 1) % 3;
    for (unsigned part = 0; part < 8; ++part) {
      const unsigned place = hilbert::gray_inverse(hilbert::rotated_right(part ^ corner, turn));
      const unsigned next_corner = corner ^ hilbert::rotated_left(hilbert::entry(place), turn);
      const unsigned next_axis = (axis + hilbert::direction(place) + 1) % 3;
      states[state][part] = {static_cast<std::uint8_t>(place), static_cast<std::uint8_t>(3 * next_corner + next_axis)};
    }
  }
  return states;
}();

}  // namespace motes::domains
