// Makes the units of small spheres: see BallTile. Compiled once for each instruction set; all give the same bits.
#pragma once

#include "image/balls/ball_normals.h"
#include "image/balls/ball_tile.h"
#include "image/balls/surface_words.h"
#include "image/light/surface_lanes.h"

namespace motes::MOTES_ISA {

/// Returns the number of the unit of footprints that begin in these columns and rows of a tile.
template <class Number>
MOTES_INLINE Number ball_units(const image::BallLook& look, Number column, Number row, Number phase) {
  const int to_cell = (look.size >> 1) + look.before;
  const int in_footprint = look.phase_bits + look.phase_shift;
  const Number across = (phase & ((1 << in_footprint) - 1)) >> look.phase_shift;
  const Number down = phase >> (in_footprint + look.phase_shift);
  const Number cell = ((row + to_cell) >> look.cell_bits) * look.across + ((column + to_cell) >> look.cell_bits);
  return (((cell << look.phase_bits) + down) << look.phase_bits) + across;
}

/// The light on spheres in one cell.
struct BallInCell {
  const image::BallLook& look;
  Float3 middle;  // direction to the cell's middle, at a depth of 1 m

  MOTES_INLINE BallInCell(const image::BallTile& t, int cell) : look(*t.look) {
    const auto part = [&](int number) { return static_cast<float>(number << look.cell_bits); };
    middle = {(t.first_x + part(cell % look.across)) * look.per_pixel,
              -(t.first_y + part(cell / look.across)) * look.per_pixel, -1};
  }

  /// Returns the light at places relative to the centre, to the right and up, in radii: at most white.
  MOTES_INLINE Floats3 light(Floats x, Floats y) const {
    const float wide = look.radius_px * look.per_pixel;
    const Floats3 normal = ball_normals(middle, wide, x, y);
    const Floats3 arriving = light_on(*look.light, {all3(middle) + normal * wide, normal});
    return {min(arriving.x, all(1.0f)), min(arriving.y, all(1.0f)), min(arriving.z, all(1.0f))};
  }
};

/// Calls use(number, light, edge) for vectors of a unit's pixels, in rows of 8 or 16: `edge` is the covered part.
template <class Use>
MOTES_INLINE void for_each_ball_pixel(const BallInCell& ball, int phase, const Use& use) {
  const image::BallLook& look = ball.look;
  const int phases = 1 << look.phase_bits, row_bits = look.size <= 8 ? 3 : 4;
  const auto first = [&](int part) {
    return 1 - 0.5f * static_cast<float>(look.size) - (static_cast<float>(part) + 0.5f) / static_cast<float>(phases);
  };
  const float left = first(phase & (phases - 1)), top = first(phase >> look.phase_bits);
  for (int i = 0; i < look.size << row_bits; i += static_cast<int>(kLanes)) {
    const Ints number = (Ints)lane_numbers() + i;
    const Floats x = to_floats(number & ((1 << row_bits) - 1)) + left, y = to_floats(number >> row_bits) + top;
    const Floats distance = sqrt(x * x + y * y);
    const Floats shrink = 1.0f / max(distance, all(look.radius_px));  // outside: to the rim
    const Floats edge = min(max(look.radius_px - distance + 0.5f, Floats{}), all(1.0f));
    use(i, ball.light(x * shrink, -y * shrink), edge);
  }
}

/// Stores the lowest byte of each lane.
MOTES_INLINE void store_bytes(unsigned char* to, Ints v) {
  using Bytes = std::uint8_t __attribute__((vector_size(MOTES_LANES)));
  const Bytes bytes = __builtin_convertvector(v, Bytes);
  __builtin_memcpy(to, &bytes, sizeof bytes);
}

MOTES_INLINE void make_surfaces(const BallInCell& ball, int phase, unsigned char* to) {
  const bool grey = ball.look.form == image::BallForm::shades;
  for_each_ball_pixel(ball, phase, [&](int number, Floats3 light, Floats) {
    if (grey) return store_bytes(to + number, max_ints(to_ints(light.x * 255.0f + 0.5f), all_ints(1)));
    const Uints words = surface_of(light);
    __builtin_memcpy(to + std::size_t{4} * static_cast<std::size_t>(number), &words, sizeof words);
  });
}

/// The greatest weight, which leaves room for rounding up.
inline constexpr float kMostWeight = 254;

/// Returns the factor on numbers that makes their sum `whole`, where none may be greater than kMostWeight. `each`:
/// calls what it is given with each of them.
template <class Each>
MOTES_INLINE float scale_to(float whole, const Each& each) {
  float scale = 0;
  for (int pass = 0; pass < 4; ++pass) {
    float held = 0, others = 0;
    each([&](float number) { number* scale < kMostWeight ? others += number : held += kMostWeight; });
    const float next = others > 0 ? (whole - held) / others : scale;
    if (!(next > scale)) break;
    scale = next;
  }
  return scale;
}

/// Sets weights such that each phase has the mean light of the disc. `mean`: three numbers, found if negative.
MOTES_INLINE void make_weights(const BallInCell& ball, int phase, float* mean, unsigned char* to) {
  const image::BallLook& look = ball.look;
  const int channels = look.grey ? 1 : 3, row_bits = look.size <= 8 ? 3 : 4;
  constexpr int kMost = image::kMaxFootprint * 16 + static_cast<int>(kLanes);
  float parts[3][kMost];
  for_each_ball_pixel(ball, phase, [&](int number, Floats3 light, Floats edge) {
    const Floats channel[3] = {light.x, light.y, light.z};
    for (int c = 0; c < channels; ++c) store(parts[c] + number, channel[c] * edge);
  });
  const auto for_each = [&](const auto& use) {
    for (int row = 0; row < look.size; ++row) {
      for (int column = 0; column < look.size; ++column)
        use((row << row_bits) + column, row * look.row_bytes + 3 * column);
    }
  };
  for (int c = 0; c < channels; ++c) {
    if (mean[c] < 0) {
      mean[c] = mean_on_disc([&](Floats x, Floats y) {
        const Floats3 light = ball.light(x, y);
        return c == 0 ? light.x : c == 1 ? light.y : light.z;
      });
    }
    const float whole = 255 * 3.14159265f * look.radius_px * look.radius_px * mean[c];
    const float scale =
        scale_to(whole, [&](const auto& use) { for_each([&](int number, int) { use(parts[c][number]); }); });
    float rest = 0;  // of rounding
    for_each([&](int number, int byte) {
      const float weight = parts[c][number] * scale;
      rest += weight < kMostWeight ? weight : kMostWeight;
      unsigned char* pixel = to + byte + c;
      *pixel = static_cast<unsigned char>(rest > 0 ? rest + 0.5f : 0);
      rest -= static_cast<float>(*pixel);
      if (channels == 1) pixel[1] = pixel[2] = *pixel;
    });
  }
}

MOTES_OUTLINE const unsigned char* make_ball(image::BallTile& t, int unit) {
  const image::BallLook& look = *t.look;
  const int phase_bits = 2 * look.phase_bits, cell = unit >> phase_bits, phase = unit & ((1 << phase_bits) - 1);
  const std::uint32_t begin = t.more();
  const BallInCell ball(t, cell);
  unsigned char* to = t.bytes + begin;
  if (look.form == image::BallForm::weights) {
    make_weights(ball, phase, t.mean + std::ptrdiff_t{3} * cell, to);
  } else {
    make_surfaces(ball, phase, to);
  }
  t.begin[unit] = begin;
  return to;
}

/// Returns a unit; makes it if it is not there.
MOTES_INLINE const unsigned char* ball_at(image::BallTile& t, int unit) {
  const std::uint32_t begin = t.begin[unit];
  return begin != 0 ? t.bytes + begin : make_ball(t, unit);
}

MOTES_OUTLINE void make_balls(image::BallTile& t, Ints unit, Mask there) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (there[lane] != 0) ball_at(t, unit[lane]);
  }
}

/// Returns where the units begin in t.bytes, in the lanes of `there`; makes those that are not there.
MOTES_INLINE Ints balls_at(image::BallTile& t, Ints unit, Mask there) {
  const auto begins = [&] { return (Ints)gather(reinterpret_cast<const float*>(t.begin), unit & there); };
  const Ints begin = begins();
  if (!any(there & (begin == 0))) return begin;
  make_balls(t, unit, there);
  return begins();
}

}  // namespace motes::MOTES_ISA
