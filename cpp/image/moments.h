// Motion blur and depth of field of sprites in space: the mean of still, sharp pictures at several times and from
// several points on the lens. All of it is inlined, because files compiled once for each instruction set use it.
#pragma once

#include <cstdint>

#define MOTES_ALWAYS inline __attribute__((always_inline))

namespace motes::image {

/// Least and greatest number of moments, which is always a power of two.
inline constexpr int kFewestMoments = 16, kMostMoments = 64;

struct Moment {
  float time;            // -0.5: the shutter opens; 0.5: it closes
  float lens_x, lens_y;  // on a lens whose radius is 1
  float dither;  // 0..1: added to a weight before it is truncated, so that errors of all moments cancel
  int pixel_x, pixel_y;  // position in a pixel, 1/256 px from its middle
};

/// Returns how many moments, at least `fewest`, show a motion of `motion_px` and a lens blur of diameter `spread` px
/// without visible gaps.
MOTES_ALWAYS int moments_for(float motion_px, float spread, int fewest) {
  int count = fewest;
  while (count < kMostMoments &&
         (static_cast<float>(count) < motion_px || 4 * static_cast<float>(count) < spread * spread))
    count *= 2;
  return count;
}

/// Returns the distance, px, between neighbouring images of a point whose lens blur has the diameter `spread`, px.
MOTES_ALWAYS float lens_gap(float spread, int count) {
  return 1.25f * spread / __builtin_sqrtf(static_cast<float>(count));
}

/// Calls use(number, moment) for each of `count` moments. Times, points on the lens (in a spiral of golden angles) and
/// positions in pixels are evenly spread, and independent of one another.
template <class Use>
MOTES_ALWAYS void for_each_moment(int count, const Use& use) {
  constexpr float kCosine = -0.73736888f, kSine = 0.67549029f;  // of the golden angle
  const float per = 1.0f / static_cast<float>(count);
  float x = 1, y = 0;
  for (int i = 0; i < count; ++i) {
    int reversed = 0;
    for (int bit = 1, from = count / 2; bit < count; bit *= 2, from /= 2) reversed += (i & bit) != 0 ? from : 0;
    const float radius = __builtin_sqrtf((static_cast<float>(i) + 0.5f) * per);
    Moment m;
    m.time = (static_cast<float>(reversed) + 0.5f) * per - 0.5f;
    m.lens_x = x * radius;
    m.lens_y = y * radius;
    m.dither = (static_cast<float>((i * 37) & (count - 1)) + 0.5f) * per;
    m.pixel_x = ((i * 193 + 96) & 255) - 128;
    m.pixel_y = ((i * 145 + 32) & 255) - 128;
    use(i, m);
    const float turned = x * kCosine - y * kSine;
    y = x * kSine + y * kCosine;
    x = turned;
  }
}

/// Returns the radius, px, of the lens blur at a depth of 1 / `inverse` m; negative in front of the focus.
/// `blur`: the radius at infinity, px; `focus`: distance at which things are sharp, m.
MOTES_ALWAYS float spread_at(float blur, float focus, float inverse) { return blur * (1 - focus * inverse); }

/// A rotation in 32 bits: three numbers of 9 bits, and the exponent of their unit in the upper 5 bits; 0: no rotation.
inline constexpr int kTurnBits = 9, kTurnExponent = 23;

/// Unpacks a rotation to its axis times its angle, radians.
MOTES_ALWAYS void unpack_turn(std::uint32_t word, float (&turn)[3]) {
  const std::uint32_t bits = ((word >> 27) + (127 - kTurnExponent)) << 23;
  float unit;
  __builtin_memcpy(&unit, &bits, sizeof unit);
  for (int c = 0; c < 3; ++c) {
    const auto part = static_cast<std::int32_t>(word << (32 - kTurnBits * (c + 1))) >> (32 - kTurnBits);
    turn[c] = word == 0 ? 0 : static_cast<float>(part) * unit;
  }
}

}  // namespace motes::image

#undef MOTES_ALWAYS
