#include "image/tone.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "image/curves.h"
#include "image/tile_planes.h"

namespace motes::image {
namespace {

constexpr double kKnee = 0.5;

// The 16-bit curve is a linearly interpolated table of 256 entries per octave of light, which is dense enough for an
// error below one step. Light below the first octave is black at 16 bits, too.
constexpr int kFirstOctave = -24;
constexpr int kLastOctave = 40;
constexpr int kStepBits = 8;
constexpr int kMantissaBits = 23;

std::vector<float> fine_table() {
  std::vector<float> table;
  for (int octave = kFirstOctave; octave < kLastOctave; ++octave) {
    for (int step = 0; step < 1 << kStepBits; ++step) {
      const double light = std::ldexp(1 + step / double{1 << kStepBits}, octave);
      table.push_back(static_cast<float>(srgb(roll_off(light)) * 65535));
    }
  }
  table.push_back(65535);
  return table;
}

}  // namespace

double roll_off(double light) {
  if (light <= kKnee) return light;
  const double over = (light - kKnee) / (1 - kKnee);
  return kKnee + (1 - kKnee) * (1 - 1 / std::sqrt(1 + 2 * over));  // slope 1 at the knee
}

std::vector<std::uint16_t> tone_table(double exposure) {
  std::vector<std::uint16_t> table(kToneEntries);
  constexpr int kSteps = 1 << kToneBits;
  double octave = 1;
  for (int i = 0; i < kToneEntries; ++i) {
    const int step = i % kSteps;
    if (i != 0 && step == 0) octave *= 2;
    const double half_sum = octave * (1 + (step + 0.5) / kSteps);
    const double light = 2 * half_sum / kUnit * exposure;
    table[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(srgb(roll_off(light)) * (255 * 256) + 0.5);
  }
  table[0] = 0;  // pixels without light are black
  return table;
}

std::vector<std::uint16_t> tone_16_bits(std::span<const float> light, double exposure) {
  static const std::vector<float> table = fine_table();
  constexpr std::uint32_t kFirst = (127 + kFirstOctave) << kMantissaBits;
  constexpr std::uint32_t kEnd = (127 + kLastOctave) << kMantissaBits;
  constexpr int kRest = kMantissaBits - kStepBits;
  std::vector<std::uint16_t> shown;
  shown.reserve(light.size());
  for (const float one : light) {
    const auto exposed = static_cast<float>(one * exposure);
    // The bits of a positive float are its logarithm in steps. Those of NaN look like a large number, so it is excluded
    // by the comparison.
    const std::uint32_t bits =
        exposed > 0 ? std::clamp(std::bit_cast<std::uint32_t>(exposed), kFirst, kEnd - 1) : kFirst;
    const std::size_t entry = (bits - kFirst) >> kRest;
    const float between = static_cast<float>(bits & ((1u << kRest) - 1)) / (1u << kRest);
    const float value = table[entry] + (table[entry + 1] - table[entry]) * between;
    shown.push_back(bits == kFirst ? 0 : static_cast<std::uint16_t>(value + 0.5f));
  }
  return shown;
}

}  // namespace motes::image
