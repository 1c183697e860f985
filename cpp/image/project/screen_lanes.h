// Functions that projections to fixed-size and to wide records share. Compiled once for each instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/project/project_lanes.h"
#include "simd/floats3.h"
#include "simd/quads.h"
#include "simd/simd.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {

inline constexpr float kLargest = 3.402823466e38f;

/// Converts 0..1 to 0..255, rounded to nearest, and NaN to 0.
MOTES_INLINE Uints to_byte(Floats v) {
  const Floats clamped = min(max(v, all(0.0f)), all(1.0f));
  return (Uints)to_ints(clamped * all(255.0f) + all(0.5f));
}

MOTES_INLINE Floats load_or(const float* plane, std::size_t i, float of_all) {
  return plane != nullptr ? load(plane + i) : all(of_all);
}

/// Returns the bits of finite numbers, and 0 for others.
MOTES_INLINE Uints finite_bits(Floats v) { return (Uints)only(abs(v) <= all(kLargest), v); }

/// Splits the light of additive particles into colour and alpha. Only their product is visible, with components of at
/// most 1. If all components are small, both get about the square root of the greatest, which loses little when rounded
/// to bytes; if a colour is above 1, alpha takes the excess.
MOTES_INLINE void share_light(Floats (&color)[3], Floats& alpha) {
  constexpr float kFaint = 1.0f / 16;
  const Floats opacity = min(max(alpha, all(0.0f)), all(1.0f));
  Floats light[3], most = all(0.0f), brightest = all(0.0f);
  for (int c = 0; c < 3; ++c) {
    brightest = max(brightest, color[c]);
    light[c] = min(max(color[c], all(0.0f)) * opacity, all(1.0f));
    most = max(most, light[c]);
  }
  const Mask faint = most < kFaint;
  const Mask other = (faint | (brightest > 1.0f)) & (most > 0.0f);
  if (!any(other)) return;
  const Floats root = sqrt(most) * all(255.0f);
  Ints byte = to_ints(select(faint, root, most * all(255.0f) + all(0.5f)));
  byte -= faint & (to_floats(byte) < root);  // round up, so that the colour is not above it
  const Floats part = to_floats(byte), scale = all(255.0f) / part;
  for (int c = 0; c < 3; ++c) color[c] = select(other, light[c] * scale, color[c]);
  alpha = select(other, part * all(1.0f / 255), alpha);
}

MOTES_INLINE Uints color_vector(const image::SeenTask& t, std::size_t i) {
  Floats alpha = load_or(t.alpha, i, t.alpha_of_all), color[3];
  for (int c = 0; c < 3; ++c) color[c] = load_or(t.color[c], i, t.color_of_all[c]);
  if (t.dark == 0) share_light(color, alpha);
  Uints word = to_byte(alpha) << 24;
  for (int c = 0; c < 3; ++c) word |= to_byte(color[c]) << (8 * c);
  return word;
}

/// A position relative to a camera: metres to the right, upwards and ahead.
struct ViewPosition {
  Floats across, upward, depth;
};
MOTES_INLINE ViewPosition view_position(const image::LensLanes& lens, Floats3 place) {
  const Floats3 offset = place - all3(lens.eye);
  return {dot(offset, all3(lens.right)), dot(offset, all3(lens.up)), dot(offset, all3(lens.forward))};
}
MOTES_INLINE Floats3 place_of(const image::SeenTask& t, std::size_t i) {
  return {load(t.position[0] + i), load(t.position[1] + i), load(t.position[2] + i)};
}

/// Prefetches the planes that a projection reads, because hardware prefetching comes too late. Planes that only some
/// projections read must be added.
class Ahead {
 public:
  explicit Ahead(const image::SeenTask& t) {
    add(t.position);
    add(t.color);
    add(t.alpha);
  }
  void add(const float* plane) {
    if (plane != nullptr) planes_[count_++] = plane;
  }
  void add(const float* const (&planes)[3]) {
    for (const float* plane : planes) add(plane);
  }

  /// Prefetches while particle `i` is being projected.
  MOTES_INLINE void fetch(std::size_t i) const {
    for (std::size_t p = 0; p < count_; ++p) __builtin_prefetch(planes_[p] + i + kParticles);
  }

 private:
  static constexpr std::size_t kMost = 20, kParticles = 512;

  const float* planes_[kMost];
  std::size_t count_ = 0;
};

/// Returns which particles give light or hide others; only these are sent. `dark`: see SeenTask.
MOTES_INLINE Mask gives_light(Uints color, std::uint32_t dark) {
  return (((color | dark) & 0xffffffu) != 0u) & ((color >> 24) != 0u);
}

/// Lists those of the visible particles n, n + 1, ... that have flags, which means that they touch several tiles.
/// Returns how many.
MOTES_INLINE std::size_t list_several(std::uint32_t* to, std::size_t n, Uints flags, [[maybe_unused]] Mask visible,
                                      const Selected& selected) {
#if MOTES_PRESSES
  const Uints pressed = selected.pressed(flags);
  const Mask touches = selected.front_of((Mask)(pressed != 0u));
  return squeeze(to, (lane_numbers() + static_cast<std::uint32_t>(n)) | pressed, touches);
#else
  std::size_t count = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    to[count] = static_cast<std::uint32_t>(n + selected.place(lane)) | flags[lane];
    count += static_cast<std::size_t>(visible[lane] & static_cast<std::int32_t>(flags[lane] != 0));
  }
  return count;
#endif
}

MOTES_INLINE void store_selected(std::uint32_t* to, const Selected& selected, Uints a, Uints b, Uints c, Uints d) {
#if MOTES_PRESSES
  const Quads quads = quads_of(selected.pressed(a), selected.pressed(b), selected.pressed(c), selected.pressed(d));
  __builtin_memcpy(to, &quads, sizeof quads);
#else
  const Quads quads = quads_of(a, b, c, d);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    __builtin_memcpy(to + 4 * selected.place(lane), quads.word[lane], 16);
  }
#endif
}

}  // namespace motes::MOTES_ISA
