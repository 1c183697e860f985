// Opaque sprites through a lens or an open shutter: at each pixel, the nearest surface of each exposure.
#pragma once

#include <type_traits>

#include "image/exposures.h"
#include "image/moments.h"
#include "image/raster/kind_point.h"
#include "image/raster/opaque_lanes.h"
#include "image/raster/wide_sprite.h"

namespace motes::MOTES_ISA {

/// Where one exposure shows a sprite in the pixels of each phase, px from the middle of its streak.
struct ExposedShifts {
  float x[image::kPhases], y[image::kPhases];
  float lens_x[image::kPhases], lens_y[image::kPhases];  // of infinitely distant points
  float left, right, above, below;  // bounds

  /// `move_x`, `move_y`: motion while the shutter is open, px; `spread`: radius of the lens blur, px.
  MOTES_INLINE ExposedShifts(const image::ExposedTile& to, int number, float move_x, float move_y, float spread) {
    left = above = 1e9f;
    right = below = -1e9f;
    for (int phase = 0; phase < image::kPhases; ++phase) {
      const image::Exposure& e = to.exposures->of[number][phase];
      x[phase] = e.time * move_x + e.lens_x * spread - e.pixel_x;
      y[phase] = e.time * move_y + e.lens_y * spread - e.pixel_y;
      lens_x[phase] = e.lens_x * to.blur;
      lens_y[phase] = e.lens_y * to.blur;
      left = left < x[phase] ? left : x[phase];
      right = right > x[phase] ? right : x[phase];
      above = above < y[phase] ? above : y[phase];
      below = below > y[phase] ? below : y[phase];
    }
  }

  /// Returns the numbers of a row's pixels, of which the first is in an even column.
  static MOTES_INLINE Floats in_row(const float (&of)[image::kPhases], int row) {
    const int first = 2 * (row & 1);
    Floats all;
    for (int lane = 0; lane < kWidth; ++lane) all[lane] = of[first + lane % 2];
    return all;
  }
};

/// Draws a still sprite, of a kind that has front(), at one exposure.
template <class Kind>
MOTES_INLINE void expose(const Kind& kind, const image::WideSplat& task, const ExposedShifts& shift, int number) {
  const image::ExposedTile& to = *task.memory.exposed;
  const WideSprite& s = kind.s;
  float uneven = 0;  // NOLINT(misc-const-correctness): of kinds whose parts are at other depths
  if constexpr (requires { kind.uneven(to.blur); }) uneven = kind.uneven(to.blur);
  const float box_x = kind.box_x() + uneven, box_y = kind.box_y() + uneven;
  const int above = floor_of(s.y + shift.above - box_y), below = floor_of(s.y + shift.below + box_y) + 1;
  const int left = floor_of(s.x + shift.left - box_x), right = floor_of(s.x + shift.right + box_x) + 1;
  const int first = above > 0 ? above : 0, last = below < task.rows - 1 ? below : task.rows - 1;
  const int begin = left > 0 ? left & ~1 : 0, end = right < task.columns - 1 ? right : task.columns - 1;
  const Floats center = (Floats)all_uints(s.depth);
  const Floats metres = center * all(task.radius);  // per pixel
  for (int row = first; row <= last; ++row) {
    const Floats aside = ExposedShifts::in_row(shift.x, row), down = ExposedShifts::in_row(shift.y, row);
    image::NearestSurface* const surfaces =
        to.surfaces[number] + static_cast<std::ptrdiff_t>(row) * image::kPixelStride;
    for (int column = begin; column <= end; column += kWidth) {
      // NOLINTNEXTLINE(misc-const-correctness): kinds whose parts are at other depths change them
      Floats x = numbers_from(column) - s.x - aside, y = static_cast<float>(row) - s.y - down;
      if constexpr (requires { kind.nearness(x, y); }) {
        if (to.blur > 0) {  // its parts are at other depths, and move otherwise
          const Floats moved = (kind.nearness(x, y) - 1.0f) * (to.focus * kind.inverse_depth());
          x += ExposedShifts::in_row(shift.lens_x, row) * moved;
          y += ExposedShifts::in_row(shift.lens_y, row) * moved;
        }
      }
      const Front front = kind.front(x, y);
      const unsigned covered = bits_of(front.covered & first_lanes(static_cast<std::size_t>(end + 1 - column)));
      if (covered == 0) continue;
      const Uints depth = (Uints)max(center - metres * front.nearer, all(kLeastDepth));
      keep_nearest(surfaces + column, nearest_of(depth, front.surface, 0), covered & ((1u << kLongs) - 1));
      keep_nearest(surfaces + column + kLongs, nearest_of(depth, front.surface, 1), covered >> kLongs);
    }
  }
}

/// Draws a point: at each exposure it is in one pixel, so that its light does not depend on its place.
MOTES_INLINE void expose_point(const image::WideSplat& task, const WideSprite& s, const ExposedShifts& shift,
                               int number) {
  const image::Exposure& e = task.memory.exposed->exposures->of[number][0];
  const int column = floor_of(s.x + shift.x[0] + e.pixel_x + 0.5f), row = floor_of(s.y + shift.y[0] + e.pixel_y + 0.5f);
  if (column < 0 || column >= task.columns || row < 0 || row >= task.rows) return;
  image::NearestSurface& there =
      task.memory.exposed->surfaces[number][static_cast<std::ptrdiff_t>(row) * image::kPixelStride + column];
  const image::NearestSurface here = image::NearestSurface{s.depth} << 32 | 0xff000000u | (s.color & 0xffffffu);
  there = here < there ? here : there;
}

/// Draws the record of a sprite at all exposures.
template <class Kind>
MOTES_OUTLINE void expose_all(const image::WideSplat& task, const WideSprite& sprite) {
  const image::ExposedTile& to = *task.memory.exposed;
  if constexpr (requires(Kind kind) { kind.expose(to); }) {
    Kind(task, sprite).expose(to);
  } else {
    WideSprite still = sprite;
    still.half = 0;
    Kind kind(task, still);
    float depth;
    __builtin_memcpy(&depth, &sprite.depth, sizeof depth);
    const float spread = to.blur > 0 ? image::spread_at(to.blur, to.focus, 1 / depth) : 0;
    const float move_x = 2 * sprite.half * sprite.along_x, move_y = 2 * sprite.half * sprite.along_y;
    for (int number = 0; number < image::kExposures; ++number) {
      if constexpr (requires { kind.turn_to(0.0f); }) kind.turn_to(to.exposures->of[number][0].time);
      const ExposedShifts shift(to, number, move_x, move_y, spread);
      if constexpr (std::is_same_v<Kind, Point>) {
        expose_point(task, kind.s, shift, number);
      } else {
        expose(kind, task, shift, number);
      }
    }
  }
}

}  // namespace motes::MOTES_ISA
