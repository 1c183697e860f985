// Functions that tests call in code compiled once per instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "particles/ids.h"

namespace test {

struct Probe {
  std::size_t lanes;
  /// The draws of `count` ids (with room for 16 more), after `skip` others; out: 4 uint32 per id.
  void (*draws)(const motes::particles::Ids& ids, std::size_t count, std::uint32_t step, std::uint32_t stream,
                const std::uint32_t key[2], int skip, std::uint32_t* out);
  /// Elementary functions of `count` numbers, a multiple of 16.
  void (*cos_sin_turn)(const float* turn, std::size_t count, float* cosine, float* sine);
  void (*log)(const float* v, std::size_t count, float* out);
  void (*cube_root)(const float* v, std::size_t count, float* out);

  /// For 16 groups of eight 16-bit numbers, multiplies numbers k and k + 4 by the halves of the group's weights and
  /// adds the products: four planes of 16.
  void (*pairs)(const std::uint16_t* groups, const std::int32_t* weights, std::int32_t* out);
  /// Interleaves three planes of 16 numbers.
  void (*thirds)(const std::int32_t* planes, std::uint16_t* out);
  /// Returns the greatest of the numbers that fill one vector; 2 * lanes are read.
  int (*greatest)(const std::int16_t* numbers);
};

}  // namespace test
