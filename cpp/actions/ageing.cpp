#include "actions/ageing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motes::actions {
namespace {

constexpr int kLengthBits = 29;  // a product with a 24-bit count is exact in double precision
constexpr double kMostSubsteps = 0x1p23, kMostFrames = 0x1p22;  // the largest recovered from a rounded age

double leading_bits(double value, int bits) {
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  return std::ldexp(std::nearbyint(std::ldexp(fraction, bits)), exponent - bits);
}

float below(double seconds) {
  return static_cast<float>(std::min(seconds, static_cast<double>(std::numeric_limits<float>::max())));
}

}  // namespace

Ageing ageing_of(double dt, int substep, int substeps) {
  Ageing ageing;
  const double parts = substeps;
  ageing.per_second = parts / dt;
  ageing.frames_per_second = 1 / dt;
  ageing.frame = dt;
  ageing.start = substep / parts;
  ageing.end = (substep + 1) / parts;
  // A whole frame's length is exact enough as it is. A sub-step's length is rounded, and `substeps` of them must add up
  // to a frame.
  ageing.length = substeps == 1 ? dt : leading_bits(dt / parts, kLengthBits);
  ageing.rest = (dt - parts * ageing.length) / parts;
  ageing.in_substeps = below(kMostSubsteps * dt / parts);
  ageing.in_frames = below(kMostFrames * dt);
  return ageing;
}

}  // namespace motes::actions
