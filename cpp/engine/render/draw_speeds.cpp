#include "engine/render/draw_speeds.h"

#include <algorithm>
#include <cmath>

namespace motes::engine {
namespace {

constexpr double kNewest = 0.3;   // weight of the newest sample
constexpr double kNoise = 0.02;   // relative changes below this are noise
constexpr double kLeast = 1e-4;   // minimum seconds of drawing for a sample
constexpr double kSlowest = 1.0 / 32;  // minimum speed, so a rank that was delayed once still gets tiles

}  // namespace

double smoothed(double before, double now) { return before > 0 ? (1 - kNewest) * before + kNewest * now : now; }

void DrawSpeeds::add(std::span<const DrawSample> samples) {
  const auto tells = [](const DrawSample& sample) { return std::min(sample.expected_s, sample.seconds) >= kLeast; };
  double expected = 0;
  double seconds = 0;
  for (const DrawSample& sample : samples) {
    if (!tells(sample)) continue;
    expected += sample.expected_s;
    seconds += sample.seconds;
  }
  if (expected > 0) slowness_ = smoothed(slowness_, std::clamp(seconds / expected, kSlowest, 1 / kSlowest));
  for (const DrawSample& sample : samples) {
    if (!tells(sample)) continue;
    const auto rank = static_cast<std::size_t>(sample.rank);
    if (rank >= speeds_.size()) speeds_.resize(rank + 1);
    Speed& speed = speeds_[rank];
    const double now = std::clamp(sample.expected_s / sample.seconds * (seconds / expected), kSlowest, 1 / kSlowest);
    speed.smooth = smoothed(speed.smooth, now);
    if (std::fabs(speed.smooth - speed.used) > kNoise * speed.used) speed.used = speed.smooth;
  }
}

}  // namespace motes::engine
