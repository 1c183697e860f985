#include "image/tone.h"

#include <cmath>

#include "image/curves.h"
#include "image/splat_lanes.h"

namespace motes::image {
namespace {

constexpr double kKnee = 0.5;

}  // namespace

double roll_off(double light) {
  if (light <= kKnee) return light;
  const double over = (light - kKnee) / (1 - kKnee);
  return kKnee + (1 - kKnee) * (1 - 1 / std::sqrt(1 + 2 * over));  // slope 1 at the knee
}

std::vector<std::uint8_t> tone_table(double exposure) {
  std::vector<std::uint8_t> table(kToneEntries);
  constexpr int kSteps = 1 << kToneBits;
  double octave = 1;
  for (int i = 0; i < kToneEntries; ++i) {
    const int step = i % kSteps;
    if (i != 0 && step == 0) octave *= 2;
    const double half_sum = octave * (1 + (step + 0.5) / kSteps);
    const double light = 2 * half_sum / kUnit * exposure;
    table[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(srgb(roll_off(light)) * 255 + 0.5);
  }
  table[0] = 0;  // also where there is no light at all
  return table;
}

}  // namespace motes::image
