// Shared by the kinds of sprites that are computed pixel by pixel: see docs/extending.md.
#pragma once

#include "image/layout.h"
#include "image/moments.h"
#include "image/raster/depth_blocks.h"
#include "image/raster/patch_lanes.h"
#include "image/raster/wide_lanes.h"
#include "simd/floats3.h"
#include "simd/rotations.h"

namespace motes::MOTES_ISA {

/// One wide record, unpacked. Lengths are in pixels, y points down.
struct WideSprite {
  float x, y;          // middle of the streak, relative to the centre of the tile's first pixel
  float radius;        // half of the diameter
  float half;          // half the streak's length; 0: no streak
  float along_x, along_y;  // direction of the streak, a unit vector
  float up_x, up_y;    // direction of the particle's `up`, a unit vector
  float light;         // factor on its alpha, 0..1
  float gain;          // factor on its light, at least 1; the result is clipped at white
  std::uint32_t color, depth;
  std::uint32_t tile;  // tile number, as in the record
  const unsigned char* record;
};

/// Unpacks the record at `bytes`.
MOTES_INLINE image::WideRecord record_of(const image::WideSplat& task, const unsigned char* bytes) {
  return image::wide_record(task.form, task.bits, reinterpret_cast<const std::byte*>(bytes), task.color);
}

MOTES_OUTLINE WideSprite sprite_from(const image::WideSplat& task, const unsigned char* bytes) {
  const image::WideRecord r = record_of(task, bytes);
  constexpr float kUnit = 1.0f / (1 << image::kWideBits);
  WideSprite s;
  s.x = static_cast<float>(r.x - task.origin_x) * kUnit;
  s.y = static_cast<float>(r.y - task.origin_y) * kUnit;
  s.radius = static_cast<float>(image::size_units(r.size)) * (0.5f / (1 << image::kSizeBits));
  s.half = s.along_y = 0;
  s.along_x = 1;
  if (r.dx != 0 || r.dy != 0) {
    const float dx = static_cast<float>(r.dx) * kUnit, dy = static_cast<float>(r.dy) * kUnit;
    const float length = __builtin_sqrtf(dx * dx + dy * dy);
    s.half = 0.5f * length;
    s.along_x = dx / length;
    s.along_y = dy / length;
  }
  const bool oriented = r.up_x != 0 || r.up_y != 0;
  s.up_x = oriented ? static_cast<float>(r.up_x) * (1.0f / 32767) : 0;
  s.up_y = oriented ? static_cast<float>(r.up_y) * (1.0f / 32767) : -1;
  s.light = static_cast<float>(r.light) * (1.0f / image::kAllLight);
  s.gain = r.gain();
  __builtin_memcpy(&s.color, r.color, sizeof s.color);
  s.depth = r.depth;
  s.record = bytes;
  s.tile = 0;
  if (task.form.tile != 0) __builtin_memcpy(&s.tile, bytes + task.form.tile, sizeof s.tile);
  return s;
}

/// Returns the direction to a sprite's middle in the camera's axes, at a depth of 1 m.
MOTES_INLINE Float3 middle_of(const image::WideSplat& task, const WideSprite& s) {
  constexpr float kUnit = 1.0f / (1 << image::kWideBits);
  return {(s.x + static_cast<float>(task.origin_x) * kUnit) * task.radius,
          -(s.y + static_cast<float>(task.origin_y) * kUnit) * task.radius, -1};
}

/// Returns the place of a sprite's middle in the camera's axes, m from the eye.
MOTES_INLINE Float3 place_of(const image::WideSplat& task, const WideSprite& s) {
  constexpr float kUnit = 1.0f / (1 << image::kWideBits);
  float depth;
  __builtin_memcpy(&depth, &s.depth, sizeof depth);
  const float per = task.radius * depth;
  return {(s.x + static_cast<float>(task.origin_x) * kUnit) * per,
          -(s.y + static_cast<float>(task.origin_y) * kUnit) * per, -depth};
}

/// Returns whether all surfaces in columns first_column .. last_column of rows first .. last are known to be nearer
/// than `depth`.
MOTES_INLINE bool is_hidden(const image::TilePlanes& tile, int first_column, int last_column, int first, int last,
                            float depth) {
  using image::DepthBlocks;
  if (tile.blocks == nullptr) return false;
  const int left = (first_column > 0 ? first_column : 0) >> DepthBlocks::kBits;
  const int right = (last_column < image::kTile ? last_column : image::kTile - 1) >> DepthBlocks::kBits;
  float farthest = 0;
  for (int row = first >> DepthBlocks::kBits; row <= last >> DepthBlocks::kBits; ++row) {
    for (int column = left; column <= right; ++column) {
      const int block = DepthBlocks::at(column << DepthBlocks::kBits, row << DepthBlocks::kBits);
      const float here = tile.blocks[2 * block + 1];
      farthest = here > farthest ? here : farthest;
    }
  }
  return depth > farthest;
}
/// Returns whether a sprite in rows first .. last is known to be hidden. `extent_x`: half its width with the streak,
/// px; `front`: depth of its front, m.
MOTES_INLINE bool is_hidden(const image::TilePlanes& tile, const WideSprite& s, float extent_x, int first, int last,
                            float front) {
  return is_hidden(tile, floor_of(s.x - extent_x), floor_of(s.x + extent_x) + 1, first, last, front);
}

/// A sprite at a vector of pixels: the covered part of each pixel, and that part times its light; both 0..1.
struct Glow {
  Floats cover, light;
};

/// An opaque sprite at a vector of pixels: which of them it covers, its surface (as in NearestSurface), and how much
/// nearer than its centre it is, px, at most its radius.
struct Front {
  Mask covered;
  Uints surface;
  Floats nearer;
};

MOTES_INLINE Floats clamp(Floats v, float low, float high) { return min(max(v, all(low)), all(high)); }

/// Returns surfaces of a colour, the lower 24 bits, and a shade of 0..1.
MOTES_INLINE Uints surface_of(Uints color, Floats shade) {
  return (color & 0xffffffu) | (Uints)to_ints(clamp(shade * 255.0f, 1, 255) + 0.5f) << 24;
}

/// Position of a pixel relative to a streak's middle, along it and across it, in radii.
struct Beside {
  Floats along, across;
};
MOTES_INLINE Beside beside(const WideSprite& s, Floats x, Floats y) {
  const float scale = 1 / s.radius;
  return {(x * s.along_x + y * s.along_y) * scale, (y * s.along_x - x * s.along_y) * scale};
}

/// The chord along which a pixel crosses a disc of radius 1 that moves past it. The disc covers the pixel for
/// (last - first) / streak length of the time.
struct Chord {
  Floats square;       // square of half the chord through the whole disc; 0 where it misses the pixel
  Floats first, last;  // ends of the chord; first >= last where the disc is never over the pixel
};
MOTES_INLINE Chord chord(Beside p, float half) {
  Chord c;
  c.square = max(1.0f - p.across * p.across, Floats{});
  const Floats end = sqrt(c.square);
  c.first = max(p.along - half, -end);
  c.last = min(p.along + half, end);
  return c;
}

/// Streaks with a half length below this many radii are drawn as still sprites: the difference is invisible.
inline constexpr float kShortest = 1.0f / 64;
/// Returns half the streak's length in radii; drops streaks that are too short to be seen.
MOTES_INLINE float shown_half(WideSprite& s) {
  if (!(s.half > kShortest * s.radius)) s.half = 0;
  return s.half / s.radius;
}

/// Positions of a vector of pixels of a strip: one or two rows of eight, or half a row.
struct PixelPositions {
  Floats x, y;  // relative to the centre of the tile's first pixel
};
inline constexpr int kPixelRows = kWidth > kStrip ? kWidth / kStrip : 1;
MOTES_INLINE PixelPositions place_of(const PatchPart& p, int strip, int row, int first) {
  Floats column, down;
  for (int lane = 0; lane < kWidth; ++lane) {
    column[lane] = static_cast<float>(lane % kStrip);
    down[lane] = static_cast<float>(lane / kStrip);
  }
  Floats start = all(static_cast<float>(p.start[row]));
  if constexpr (kPixelRows == 2) start = select(down == 0.0f, start, all(static_cast<float>(p.start[row + 1])));
  return {column + start + static_cast<float>(strip * kStrip + first), down + static_cast<float>(p.first + row)};
}

/// Start of a vector of pixels in a part: strip, row, and column within the strip.
struct InPart {
  int strip, row, first;
  MOTES_INLINE int number(const PatchPart& p) const { return kStrip * (strip * p.stride + row) + first; }
};

/// Returns the lanes of a vector of a part whose pixels lie in the tile and have no nearer surface.
MOTES_INLINE Mask may_show(const image::TilePlanes& tile, const PatchPart& part, const InPart& at, Mask there,
                           Floats depth) {
  Mask shows{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (there[lane] == 0) continue;
    const int row = at.row + static_cast<int>(lane) / kStrip;
    const int column = part.start[row] + at.strip * kStrip + at.first + static_cast<int>(lane) % kStrip;
    if (row >= part.rows || column < 0 || column >= image::kTile) continue;
    std::uint32_t bits;
    const float here = depth[lane];
    __builtin_memcpy(&bits, &here, sizeof bits);
    const std::ptrdiff_t pixel = static_cast<std::ptrdiff_t>(part.first + row) * image::kPixelStride + column;
    shows[lane] = bits <= tile.surfaces[pixel] >> 32 ? -1 : 0;
  }
  return shows;
}

/// Calls use(x, y, in_part) for all vectors of pixels of a part, with their positions in the tile and in the part.
template <class Use>
MOTES_INLINE void for_each_vector(const PatchPart& p, const Use& use) {
  for (int strip = 0; strip < p.strips; ++strip) {
    for (int row = 0; row < p.rows; row += kPixelRows) {
      for (int first = 0; first < kStrip; first += kWidth) {
        const PixelPositions at = place_of(p, strip, row, first);
        use(at.x, at.y, InPart{strip, row, first});
      }
    }
  }
}

/// Weight of a fully covered pixel in a Patch.
inline constexpr float kPixelWeight = 16384;
MOTES_INLINE Ints weight_of(Floats part) { return to_ints(clamp(part, 0, 1) * kPixelWeight + 0.5f); }

template <class Kind>
MOTES_INLINE void weigh_pixels(const Kind& kind, Patch<2>& p) {
  for_each_vector(p, [&](Floats x, Floats y, const InPart& in_part) {
    const Glow glow = kind.glow(x - kind.s.x, y - kind.s.y);
    const int at = in_part.number(p);
    store_narrow(p.cover + at, weight_of(glow.cover));
    store_narrow(p.light + at, weight_of(glow.light));
  });
}

/// The position and orientation of a card or a mesh relative to the camera, unpacked from its record.
///
/// Directions are in the camera's axes: x to the right, y up, z towards the camera. The particle is `depth` metres
/// ahead, and (middle_x, middle_y) px right of and below the picture's middle.
struct CameraPose {
  Float3 right, up, front;  // the particle's own x, y and z axis, unit vectors
  float middle_x, middle_y;
  float depth, scale;  // m; m per unit of length of a mesh, or longer side of a card, m
  Float3 turn;         // rotation while the shutter is open: axis times angle, radians
  float dx, dy;        // motion on the screen in that time, px

  MOTES_INLINE CameraPose(const image::WideSplat& task, const WideSprite& s) {
    image::PosedRecord r;
    __builtin_memcpy(&r, s.record, sizeof r);
    float q[4], square = 0;
    for (int c = 0; c < 4; ++c) {
      q[c] = static_cast<float>(r.turn[c]);
      square += q[c] * q[c];
    }
    const float part = square > 0 ? 1.0f / __builtin_sqrtf(square) : 0;
    const float x = q[0] * part, y = q[1] * part, z = q[2] * part, w = q[3] * part;
    right = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)};
    up = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)};
    front = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)};
    constexpr float kUnit = 1.0f / (1 << image::kWideBits);
    middle_x = s.x + static_cast<float>(task.origin_x) * kUnit;
    middle_y = s.y + static_cast<float>(task.origin_y) * kUnit;
    __builtin_memcpy(&depth, &s.depth, sizeof depth);
    scale = r.scale;
    dx = static_cast<float>(r.dx) * kUnit;
    dy = static_cast<float>(r.dy) * kUnit;
    std::uint32_t word;
    __builtin_memcpy(&word, &r.up_x, sizeof word);
    float by[3];
    image::unpack_turn(word, by);
    turn = of(by);
  }

  MOTES_INLINE bool turns() const { return turn.x != 0 || turn.y != 0 || turn.z != 0; }

  /// Returns the pose at a moment; this pose is the one when the shutter closes.
  MOTES_INLINE CameraPose at(const image::Moment& moment) const {
    CameraPose then = *this;
    if (!turns()) return then;
    const Rotations by = rotation_by(all3(turn) * (moment.time - 0.5f));
    const Floats3 x = turned_x(by), y = turned_y(by), z = turned_z(by);
    for (Float3* axis : {&then.right, &then.up, &then.front}) {
      const Float3 a = *axis;
      *axis = {x.x[0] * a.x + y.x[0] * a.y + z.x[0] * a.z, x.y[0] * a.x + y.y[0] * a.y + z.y[0] * a.z,
               x.z[0] * a.x + y.z[0] * a.y + z.z[0] * a.z};
    }
    return then;
  }
};

/// The nearest surfaces at a tile's pixels, which hide what is behind them. They are sharp: a point that the lens blurs
/// is tested where it would be without blur.
struct Walls {
  const std::uint32_t* depth = nullptr;  // null: nothing hides anything
  float fade;                            // as in WideSplat
  int columns, rows;                     // of the tile

  /// Returns the visible part, 0..1, of a point (x, y), px, at depth `at`, m. Outside the tile, the surfaces at its
  /// edge are extrapolated as planes.
  MOTES_INLINE float visible(float x, float y, float at) const {
    const int column = inside(x, columns), row = inside(y, rows);
    float wall = wall_at(column, row);
    const float out_x = beyond(x, columns), out_y = beyond(y, rows);
    if (out_x != 0 || out_y != 0) {
      const float here = 1 / wall;
      float inverse = here;
      if (out_x != 0) inverse += size_of(out_x) * (here - 1 / wall_at(inward(column, columns), row));
      if (out_y != 0) inverse += size_of(out_y) * (here - 1 / wall_at(column, inward(row, rows)));
      wall = inverse > 1e-12f ? 1 / inverse : __builtin_inff();
    }
    const float room = wall - at;
    if (!(fade > 0)) return room >= 0 ? 1.0f : 0.0f;
    return room > 0 ? (room * fade < 1 ? room * fade : 1.0f) : 0.0f;
  }

 private:
  MOTES_INLINE float wall_at(int column, int row) const {
    float wall;
    __builtin_memcpy(&wall, depth + static_cast<std::ptrdiff_t>(row) * image::kPixelStride + column, sizeof wall);
    return wall;
  }
  static MOTES_INLINE int inside(float at, int count) {
    return at > 0 ? (at < static_cast<float>(count - 1) ? static_cast<int>(at + 0.5f) : count - 1) : 0;
  }
  static MOTES_INLINE float beyond(float at, int count) {
    const float last = static_cast<float>(count - 1);
    return at < 0 ? at : at > last ? at - last : 0;
  }
  static MOTES_INLINE int inward(int at, int count) { return at == 0 ? (count > 1 ? 1 : 0) : at - 1; }
};

/// The moments that show a card or a mesh: see image/moments.h.
struct PosedMoments {
  int count = 0;  // 0: it neither turns nor is out of focus
  float blur = 0;  // greatest blur radius of any part, px
  float uneven = 0;  // greatest difference from the blur radius at its middle, px
  float larger = 1;  // factor by which it is drawn larger, and fainter, to fill gaps between points on the lens
  const image::Exposure* one;  // the phases of the only exposure that is drawn; null: all moments are
  int shown = 0;  // number of moments that are drawn

  /// `reach`: greatest distance of a part from its middle, m; `size`: approximate width, px; `half`: of the streak, px.
  MOTES_INLINE PosedMoments(const image::SpaceSplat& camera, const CameraPose& pose, float reach, float size,
                            float half, const image::Exposure* exposure)
      : one(exposure) {
    if (!(camera.blur > 0) && !pose.turns() && one == nullptr) return;
    const float middle = image::spread_at(camera.blur, camera.focus, 1 / pose.depth), left = pose.depth - reach;
    for (const float depth : {left > camera.near ? left : camera.near, pose.depth + reach}) {
      const float here = image::spread_at(camera.blur, camera.focus, 1 / depth);
      const float wide = size_of(here), apart = size_of(here - middle);
      blur = blur > wide ? blur : wide;
      uneven = uneven > apart ? uneven : apart;
    }
    const float spread = 2 * size_of(middle);
    const float angle = __builtin_sqrtf(dot(pose.turn, pose.turn));
    count = image::moments_for(2 * half + 0.5f * size * angle, spread, image::kFewestMoments);
    const float gap = image::lens_gap(spread, count);
    larger = gap > size ? gap / (size > 0.25f ? size : 0.25f) : 1;
    larger = larger > 1 ? larger : 1;
    shown = one == nullptr ? count : count / image::kExposures;
    static_assert(image::kMostMoments <= image::kExposures * image::kPhases);
  }

  /// Calls use(number, moment) for the moments that are drawn. Those of one exposure are its phases, so that it shows
  /// what is blended as it shows what is opaque.
  template <class Use>
  MOTES_INLINE void for_each(const Use& use) const {
    if (one == nullptr) return image::for_each_moment(count, use);
    for (int i = 0; i < shown; ++i) {
      const image::Exposure& e = one[i * (image::kPhases / shown)];
      constexpr float kUnit = 1 << image::kWideBits;
      use(i,
          image::Moment{e.time, e.lens_x, e.lens_y, 0.5f, floor_of(-e.pixel_x * kUnit), floor_of(-e.pixel_y * kUnit)});
    }
  }
};

}  // namespace motes::MOTES_ISA
