// Functions and shapes that tests call in code compiled once per instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "shapes/shape.h"

namespace test {

/// Counts are multiples of 16.
struct FunctionsProbe {
  using One = void (*)(const float* v, std::size_t count, float* out);
  using Two = void (*)(const float* a, const float* b, std::size_t count, float* out);
  One sin, cos, exp, exp2, log, asin, acos, natural_log, floor;
  Two pow, atan2, power, modulo;

  void (*curl)(const float* const* p, std::size_t count, int octaves, double time, std::uint32_t seed,
               float* const* out);

  /// Noise at (x, y, z, time).
  void (*noise)(const float* const* p, std::size_t count, int octaves, std::uint32_t field, float* out);

  /// Shape::hit of the paths from p to p + path; part is below 0 if there is no hit.
  void (*hit)(const motes::shapes::Shape&, const float* const* p, const float* const* path, std::size_t count,
              float* part, float* const* normal);

  /// Where the paths of velocities may meet a box's faces, by the exact test of both ends and by the first one: 1 or 0.
  void (*nears)(const motes::shapes::Shape& box, const float* const* p, const float* const* velocity, float dt,
                std::size_t count, float* exact, float* first);
};

}  // namespace test
