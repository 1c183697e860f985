// What stands in space and moves, turns or is out of focus is the mean of still, sharp pictures of it, at several
// times and from several places on the lens. Everything is always inlined: files that are compiled once for each
// instruction set use it.
#pragma once

#include <cstdint>

#define MOTES_ALWAYS inline __attribute__((always_inline))

namespace motes::image {

/// Numbers of moments are powers of two.
inline constexpr int kFewestMoments = 16, kMostMoments = 64;

struct Moment {
  float time;            // -0.5: the shutter opens; 0.5: it closes
  float lens_x, lens_y;  // on a lens whose radius is 1
  float round;           // 0..1, added before a weight is cut to a whole number: together they cut off nothing
  int pixel_x, pixel_y;  // where in a pixel, 1/256 px from its middle
};

/// Returns how many moments show something that moves by `way` px and is spread by the lens over `spread` px without
/// visible gaps.
MOTES_ALWAYS int moments_for(float way, float spread, int fewest) {
  int count = fewest;
  while (count < kMostMoments && (static_cast<float>(count) < way || 4 * static_cast<float>(count) < spread * spread))
    count *= 2;
  return count;
}

/// Returns how far apart places on the lens let something appear that is spread over `spread` px.
MOTES_ALWAYS float lens_gap(float spread, int count) {
  return 1.25f * spread / __builtin_sqrtf(static_cast<float>(count));
}

/// Calls use(number, moment) for each of `count` moments. Times, places on the lens (in a spiral of golden angles) and
/// in pixels are evenly spread, and independent of one another.
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
    m.round = (static_cast<float>((i * 37) & (count - 1)) + 0.5f) * per;
    m.pixel_x = ((i * 193 + 96) & 255) - 128;
    m.pixel_y = ((i * 145 + 32) & 255) - 128;
    use(i, m);
    const float turned = x * kCosine - y * kSine;
    y = x * kSine + y * kCosine;
    x = turned;
  }
}

/// Returns by how much a lens spreads something at a depth whose inverse is given, px: the radius, with the sign of
/// the side on which it appears. `blur`: the radius of what is infinitely far, px; `focus`: m to what is sharp.
MOTES_ALWAYS float spread_at(float blur, float focus, float inverse) { return blur * (1 - focus * inverse); }

/// A turn as 32 bits: three numbers of 9 bits, and the exponent of their unit; 0: none.
inline constexpr int kTurnBits = 9, kTurnExponent = 23;

/// Unpacks a turn: its axis times its angle, radians.
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
