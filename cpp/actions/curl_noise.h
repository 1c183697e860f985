// curl_noise: v += strength curl(x / scale) dt, a divergence-free acceleration (particles/noise.h).
//
// The field is keyed by the seed, the system and a number that the script gives. Unlike draws, it does not depend on
// the action's place in the list: it must stay the same when the list around it changes from frame to frame.
//
// Along a periodic axis a whole number of cells fits into the period, so the field is the same at both ends. Cells are
// then no cubes: the flow is stretched as they are, which keeps it free of divergence, and its root mean square is
// kept.
#pragma once

#include "actions/lanes.h"
#include "particles/noise.h"

namespace motes::MOTES_ISA {

/// Each octave has half the size and half the speed of the one before it.
inline constexpr float kOctaveGain = 0.5f;

/// The cells of a noise along one axis.
struct NoiseAxis {
  int cells = 0;  // per period; 0: the axis is not periodic
  float low = 0, edge = 0;  // m
  double stretch = 1;  // of the edge, relative to the scale

  MOTES_INLINE Floats to_cells(Floats x) const { return (cells > 0 ? x - low : x) / edge; }
};

/// Returns the cells of edge length `scale`, m, or the nearest one that fits into the axis's period.
inline NoiseAxis noise_axis(double scale, const particles::Periods* periods, int axis) {
  if (periods == nullptr || !periods->has(axis)) return {0, 0, static_cast<float>(scale)};
  constexpr double kMost = 1 << 23;  // beyond that, floats have no fraction
  const double length = (*periods)[axis].length();
  const double cells = __builtin_fmin(__builtin_fmax(__builtin_floor(length / scale + 0.5), 1), kMost);
  const double edge = length / cells;
  return {static_cast<int>(cells), (*periods)[axis].low, static_cast<float>(edge), edge / scale};
}

inline void curl_noise(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::curl_noise, double>(p);
  const int octaves = static_cast<int>(n.octaves);
  float square = 0, gain = 1;  // mean square of the sum of independent octaves
  for (int k = 0; k < octaves; ++k, gain *= kOctaveGain) square += gain * gain;
  const float change = static_cast<float>(n.strength) * s.dt / __builtin_sqrtf(square);
  constexpr double kMostTime = 1e15;  // beyond that, doubles have no fraction
  const double time = __builtin_fmin(__builtin_fmax(n.speed * s.time, -kMostTime), kMostTime);
  const NoiseAxis x = noise_axis(n.scale, p.periods, 0), y = noise_axis(n.scale, p.periods, 1),
                  z = noise_axis(n.scale, p.periods, 2);
  const double whole =
      __builtin_sqrt((x.stretch * x.stretch + y.stretch * y.stretch + z.stretch * z.stretch) * (1.0 / 3));
  const auto along = [&](const NoiseAxis& axis) { return change * static_cast<float>(axis.stretch / whole); };
  const float by_x = along(x), by_y = along(y), by_z = along(z);
  const NoiseKey from{s.key, static_cast<std::uint32_t>(n.field), {x.cells, y.cells, z.cells}};
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 at = load3(b, kPositionAt, i), v = load3(b, kVelocityAt, i);
    const Floats3 flow = curl({x.to_cells(at.x), y.to_cells(at.y), z.to_cells(at.z)}, octaves, kOctaveGain, time, from);
    store3(b, kVelocityAt, i, {v.x + flow.x * by_x, v.y + flow.y * by_y, v.z + flow.z * by_z});
  }
}

}  // namespace motes::MOTES_ISA
