// curl_noise: v += strength curl(x / scale) dt, a divergence-free acceleration (particles/noise.h).
//
// The field is keyed by the seed, the system and a number that the script gives. Unlike draws, it does not depend on
// the action's place in the list: it must stay the same when the list around it changes from frame to frame.
#pragma once

#include "actions/lanes.h"
#include "particles/noise.h"

namespace motes::MOTES_ISA {

/// Each octave has half the size and half the speed of the one before it.
inline constexpr float kOctaveGain = 0.5f;

inline void curl_noise(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::curl_noise, double>(p);
  const int octaves = static_cast<int>(n.octaves);
  float square = 0, gain = 1;  // mean square of the sum of independent octaves
  for (int k = 0; k < octaves; ++k, gain *= kOctaveGain) square += gain * gain;
  const float change = static_cast<float>(n.strength) * s.dt / __builtin_sqrtf(square);
  constexpr double kMostTime = 1e15;  // beyond that, doubles have no fraction
  const double time = __builtin_fmin(__builtin_fmax(n.speed * s.time, -kMostTime), kMostTime);
  const NoiseKey from{s.key, static_cast<std::uint32_t>(n.field)};
  const Floats scale = all(static_cast<float>(n.scale));
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 x = load3(b, kPositionAt, i);
    const Floats3 flow = curl({x.x / scale, x.y / scale, x.z / scale}, octaves, kOctaveGain, time, from);
    store3(b, kVelocityAt, i, load3(b, kVelocityAt, i) + flow * change);
  }
}

}  // namespace motes::MOTES_ISA
