// Smooth random fields over space and time: gradient noise (K. Perlin 1985; quintic blend of 2002), and its curl.
//
// Space is divided into cells of edge length 1. Each corner of a cell holds three random gradients, given by a hash of
// its integer coordinates and the key; quintic weights blend the linear functions of the corners, so the field and its
// first two derivatives are continuous. Three such noises form a vector potential. The curl of a potential has no
// divergence, and the derivatives here are exact, not differences (R. Bridson et al., "Curl-noise for procedural fluid
// flow", 2007). In time the potential blends from the noise of one integer time to that of the next with the same
// weights.
#pragma once

#include "particles/streams.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

struct Uints3 {
  Uints x, y, z;
};

/// The positions of a vector of points in their cells, along one axis: the lower and the upper corner, the fraction of
/// the edge beyond the lower one, the weight of the upper one and the weight's derivative.
struct CellAxis {
  Uints corner, upper;
  Floats part, weight, change;
};

/// The eight corners of a cell: bit 0 of the index is set for the upper ones along x, bit 1 along y, bit 2 along z.
struct Corners {
  Uints3 at[8];
};

template <class Integer>
MOTES_INLINE Integer with_key(Integer w, std::uint32_t key) {
  return w * 1664525u + key;
}

/// Hashes four integers at all corners of a cell, with pcg4d of M. Jarzynski and M. Olano, "Hash functions for GPU
/// rendering", JCGT 2020. The increments are the key, so a different key gives a different field. All corners advance
/// together, step by step, since each product waits for the previous one. The fourth integer must have passed through
/// `with_key`.
MOTES_INLINE Corners hash(const CellAxis& x_axis, const CellAxis& y_axis, const CellAxis& z_axis, Uints keyed_w,
                          const std::uint32_t key[4]) {
  const auto each = [](auto step) __attribute__((always_inline)) {
#pragma GCC unroll 8
    for (std::uint32_t c = 0; c < 8; ++c) step(c);
  };
  Uints x[8], y[8], z[8], t[8];
  each([&](std::uint32_t c) __attribute__((always_inline)) {
    x[c] = ((c & 1u) != 0 ? x_axis.upper : x_axis.corner) * 1664525u + key[0];
    y[c] = ((c >> 1 & 1u) != 0 ? y_axis.upper : y_axis.corner) * 1664525u + key[1];
    z[c] = (c >> 2 != 0 ? z_axis.upper : z_axis.corner) * 1664525u + key[2];
    t[c] = keyed_w;
  });
  const auto mix = [&]() __attribute__((always_inline)) {
    each([&](std::uint32_t c) __attribute__((always_inline)) { x[c] += y[c] * t[c]; });
    each([&](std::uint32_t c) __attribute__((always_inline)) { y[c] += z[c] * x[c]; });
    each([&](std::uint32_t c) __attribute__((always_inline)) { z[c] += x[c] * y[c]; });
    each([&](std::uint32_t c) __attribute__((always_inline)) { t[c] += y[c] * z[c]; });
  };
  mix();
  each([&](std::uint32_t c) __attribute__((always_inline)) {
    x[c] ^= x[c] >> 16;
    y[c] ^= y[c] >> 16;
    z[c] ^= z[c] >> 16;
    t[c] ^= t[c] >> 16;
  });
  mix();
  Corners corners;
  each([&](std::uint32_t c) __attribute__((always_inline)) { corners.at[c] = {x[c], y[c], z[c]}; });
  return corners;
}

/// Returns corner numbers modulo `cells`, as 0 .. cells - 1.
MOTES_INLINE Ints wrapped(Ints corner, int cells) {
  const Ints turns = to_ints(to_floats(corner) / static_cast<float>(cells));  // exact, or one too many by rounding
  Ints rest = corner - turns * cells;
  rest += (rest < 0) & cells;
  return rest - ((rest >= cells) & cells);
}

/// Returns where points at `v`, in edges of a cell, are. The cells repeat after `cells` of them; 0: never.
MOTES_INLINE CellAxis cell_axis(Floats v, int cells = 0) {
  v = min(max(v, all(-8388608.0f)), all(8388608.0f));  // beyond, floats have no fraction; this also removes NaN
  Ints corner = to_ints(v);
  corner += to_floats(corner) > v;  // a true mask is -1: down, not towards zero
  const Floats f = v - to_floats(corner);
  const Floats weight = f * f * f * (f * (f * 6.0f - 15.0f) + 10.0f);
  Ints upper = corner + 1;
  if (cells > 0) {
    corner = wrapped(corner, cells);
    upper = wrapped(upper, cells);
  }
  return {(Uints)corner, (Uints)upper, f, weight, f * f * (f * (f * 30.0f - 60.0f) + 30.0f)};
}

// A gradient in the cube -1..1 has ten bits per component. They become the fraction of a float in 1..2, which needs no
// conversion: gradient = (fraction - kMiddle) kGradient.
inline constexpr float kMiddle = 1.0f + 511.5f / 1024, kGradient = 1024 / 511.5f;
MOTES_INLINE Floats fraction(Uints word) { return (Floats)((word & (1023u << 13)) | 0x3f800000u); }
MOTES_INLINE Floats3 fractions(Uints word) { return {fraction(word << 13), fraction(word << 3), fraction(word >> 7)}; }

/// Adds to `sum` the gradient of weight(p) g . (p - corner): one corner's part of one noise, too small by the factor
/// kGradient. The omitted term, weight kMiddle, is the same for all components and all noises, so the curl does not
/// contain it.
MOTES_INLINE void add_corner(Floats3& sum, Floats3 g, Floats3 from_corner, Floats middle, Floats weight,
                             Floats3 change) {
  sum = sum + g * weight + change * (dot(g, from_corner) - middle);
}

/// Returns the curl of three noises at one integer time, too small by the factor kGradient.
MOTES_INLINE Floats3 curl_slice(const CellAxis& x, const CellAxis& y, const CellAxis& z, std::uint32_t slice,
                                const std::uint32_t key[4]) {
  Floats3 a{}, b{}, c{};  // gradients of the potential's components
  const Corners corners = hash(x, y, z, all_uints(with_key(slice, key[3])), key);
#pragma GCC unroll 8
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    const std::uint32_t i = corner & 1u, j = corner >> 1 & 1u, k = corner >> 2;
    const Uints3& bits = corners.at[corner];
    const Floats wx = i != 0 ? x.weight : 1.0f - x.weight, dx = i != 0 ? x.change : -x.change;
    const Floats wy = j != 0 ? y.weight : 1.0f - y.weight, dy = j != 0 ? y.change : -y.change;
    const Floats wz = k != 0 ? z.weight : 1.0f - z.weight, dz = k != 0 ? z.change : -z.change;
    const Floats3 from_corner{x.part - static_cast<float>(i), y.part - static_cast<float>(j),
                              z.part - static_cast<float>(k)};
    const Floats middle = (from_corner.x + from_corner.y + from_corner.z) * kMiddle;
    const Floats weight = wx * wy * wz;
    const Floats3 change{dx * wy * wz, wx * dy * wz, wx * wy * dz};
    add_corner(a, fractions(bits.x), from_corner, middle, weight, change);
    add_corner(b, fractions(bits.y), from_corner, middle, weight, change);
    add_corner(c, fractions(bits.z), from_corner, middle, weight, change);
  }
  return {c.y - b.z, a.z - c.x, b.x - a.y};
}

/// Selects a curl noise: the key of the run, and the number of the noise in it. Along each axis the noise repeats after
/// this many cells, at most 2^23; 0: never.
struct NoiseKey {
  particles::Key key;
  std::uint32_t stream;
  int cells[3] = {};
};

/// Returns a velocity without divergence at the points `p`, with a root mean square of 1 for one octave. Octave k has
/// features of size 2^-k and `gain`^k times the speed of the first one. At integer `time`s the fields are independent
/// of each other; in between the field changes smoothly. |p| 2^octaves should stay below 1e6: beyond that floats run
/// out of fraction bits.
inline Floats3 curl(Floats3 p, int octaves, float gain, double time, const NoiseKey& from) {
  constexpr float kUnit = kGradient / 1.2205f;  // measured: the root mean square of the curl
  const auto cut = static_cast<std::int64_t>(time);
  const std::int64_t floor = static_cast<double>(cut) > time ? cut - 1 : cut;
  const auto t = static_cast<float>(time - static_cast<double>(floor));
  const float later = t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f), sooner = 1.0f - later;
  // Blending two independent fields weakens the result; this factor keeps the mean speed.
  const float even = kUnit / __builtin_sqrtf(later * later + sooner * sooner);
  Floats3 sum{};
  float amplitude = even;
  for (int octave = 0; octave < octaves; ++octave) {
    const std::uint32_t key[4] = {from.key.low, from.key.high, from.stream * 2654435769u,
                                  static_cast<std::uint32_t>(octave) * 2246822519u + 3266489917u};
    const CellAxis x = cell_axis(p.x, from.cells[0] << octave), y = cell_axis(p.y, from.cells[1] << octave),
                   z = cell_axis(p.z, from.cells[2] << octave);
    const int slices = later > 0.0f ? 2 : 1;
    for (int k = 0; k < slices; ++k) {
      const auto slice = static_cast<std::uint32_t>(floor + k);
      sum = sum + curl_slice(x, y, z, slice, key) * (amplitude * (k == 0 ? sooner : later));
    }
    p = p * 2.0f;
    amplitude *= gain;
  }
  return sum;
}

/// Returns one noise at one integer time per lane, too small by the factor kGradient.
MOTES_INLINE Floats noise_slice(const CellAxis& x, const CellAxis& y, const CellAxis& z, Uints slice,
                                const std::uint32_t key[4]) {
  Floats sum{};
  const Corners corners = hash(x, y, z, with_key(slice, key[3]), key);
#pragma GCC unroll 8
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    const std::uint32_t i = corner & 1u, j = corner >> 1 & 1u, k = corner >> 2;
    const Floats wx = i != 0 ? x.weight : 1.0f - x.weight;
    const Floats wy = j != 0 ? y.weight : 1.0f - y.weight;
    const Floats wz = k != 0 ? z.weight : 1.0f - z.weight;
    const Floats3 from_corner{x.part - static_cast<float>(i), y.part - static_cast<float>(j),
                              z.part - static_cast<float>(k)};
    const Floats middle = (from_corner.x + from_corner.y + from_corner.z) * kMiddle;
    sum = sum + (dot(fractions(corners.at[corner].x), from_corner) - middle) * (wx * wy * wz);
  }
  return sum;
}

/// Returns noise at the points `p`, with a root mean square of 1/3. It depends only on the arguments, not on the run.
/// Octave k has features of size 2^-k and 2^-k times the strength of the first one. It changes in time like `curl`. NaN
/// if an argument is not finite.
inline Floats noise(Floats3 p, Floats time, int octaves, std::uint32_t field) {
  constexpr float kUnit = kGradient / (3 * 0.1912f);  // measured: the root mean square of one octave
  const Floats strange = (p.x - p.x) + (p.y - p.y) + (p.z - p.z) + (time - time);  // NOLINT(misc-redundant-expression)
  const CellAxis t = cell_axis(time);
  const Floats sooner = 1.0f - t.weight;
  const bool still = !any(t.weight > 0.0f);
  Floats sum{};
  float amplitude = 1, square = 0;
  for (int octave = 0; octave < octaves; ++octave) {
    const std::uint32_t key[4] = {3363023517u, 1013904223u, field * 2654435769u,
                                  static_cast<std::uint32_t>(octave) * 2246822519u + 3266489917u};
    const CellAxis x = cell_axis(p.x), y = cell_axis(p.y), z = cell_axis(p.z);
    sum = sum + noise_slice(x, y, z, t.corner, key) * sooner * amplitude;
    if (!still) sum = sum + noise_slice(x, y, z, t.corner + 1u, key) * t.weight * amplitude;
    p = p * 2.0f;
    square += amplitude * amplitude;
    amplitude *= 0.5f;
  }
  const Floats even = sqrt(t.weight * t.weight + sooner * sooner) * __builtin_sqrtf(square);
  return sum * kUnit / even + strange;
}

}  // namespace motes::MOTES_ISA
