// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/wide_lanes.h"

#include "image/all_kinds.h"
#include "image/grid.h"

namespace motes::MOTES_ISA {
namespace {

using image::kLightStride;
using image::kPixelStride;
using image::TilePlanes;
using image::WideSplat;

// The greatest weight of light, so that the opacity of 255 stays below 65536: see opacity_of().
constexpr float kFull = 255 * 256;

// Longer streaks of narrow sprites, px, are not normalised: that they lie between pixels evens out along their way.
constexpr float kLongest = 512;

WideSprite sprite_from(const WideSplat& task, const unsigned char* bytes) {
  image::WideRecord r;
  __builtin_memcpy(&r, bytes, sizeof r);
  constexpr float kUnit = 1.0f / (1 << image::kWideBits);
  WideSprite s;
  s.x = static_cast<float>(r.x - task.origin_x) * kUnit;
  s.y = static_cast<float>(r.y - task.origin_y) * kUnit;
  s.radius = static_cast<float>(r.size) * (0.5f / (1 << image::kSizeBits));
  const float dx = static_cast<float>(r.dx) * kUnit, dy = static_cast<float>(r.dy) * kUnit;
  const float length = __builtin_sqrtf(dx * dx + dy * dy);
  s.half = 0.5f * length;
  s.along_x = length > 0 ? dx / length : 1;
  s.along_y = length > 0 ? dy / length : 0;
  const bool oriented = r.up_x != 0 || r.up_y != 0;
  s.up_x = oriented ? static_cast<float>(r.up_x) * (1.0f / 32767) : 0;
  s.up_y = oriented ? static_cast<float>(r.up_y) * (1.0f / 32767) : -1;
  s.light = static_cast<float>(r.light) * (1.0f / image::kAllLight);
  s.color = word_at(bytes + 8);
  s.depth = r.depth;
  return s;
}

// Pixels from first to last: those of a sprite, or none.
struct Pixels {
  int first, last;
};
MOTES_INLINE Pixels between(float low, float high, int least, int greatest) {
  // One more at each end: rounding must not lose a pixel.
  Pixels p{least, greatest};
  if (low > static_cast<float>(least) + 1)
    p.first = low < static_cast<float>(greatest) + 2 ? static_cast<int>(low) - 1 : greatest + 1;
  if (high < static_cast<float>(greatest) - 1)
    p.last = high > static_cast<float>(least) - 2 ? static_cast<int>(high + 2) - 1 : least - 1;
  return p;
}
MOTES_INLINE Pixels rows_of(const WideSprite& s, float reach, int least, int greatest) {
  const float extent = reach + s.half * (s.along_y < 0 ? -s.along_y : s.along_y);
  return between(s.y - extent, s.y + extent, least, greatest);
}
// In one row: what is within `reach` of the streak's line, and not beyond its ends.
struct Outline {
  float extent;       // to each side of the middle
  float shift, side;  // per row: where the streak's line is, and how far its edge is from there

  MOTES_INLINE Outline(const WideSprite& s, float reach) {
    extent = reach + s.half * (s.along_x < 0 ? -s.along_x : s.along_x);
    const float slope = s.along_y < 0 ? -s.along_y : s.along_y;
    const bool steep = s.half > 0 && slope > 0.01f;
    shift = steep ? s.along_x / s.along_y : 0;
    side = steep ? reach / slope : extent;
  }
};
MOTES_INLINE Pixels columns_of(const WideSprite& s, const Outline& o, float y, int least, int greatest) {
  const float middle = y * o.shift;
  const float low = middle - o.side > -o.extent ? middle - o.side : -o.extent;
  const float high = middle + o.side < o.extent ? middle + o.side : o.extent;
  return between(s.x + low, s.x + high, least, greatest);
}

MOTES_INLINE Floats numbers_from(int first) {
  Floats v;
  for (int lane = 0; lane < kWidth; ++lane) v[lane] = static_cast<float>(lane);
  return v + static_cast<float>(first);
}

MOTES_INLINE Uints weight_of(Floats part, float scale, float most) {
  return (Uints)to_ints(clamp(part * scale, 0, most) + 0.5f);
}

// What weights are multiplied by. Narrow sprites are sampled by so few pixels that their light would depend on where
// they are: it is divided by the sum over all pixels, inside the tile or not.
template <class Kind>
float scale_of(const Kind& kind) {
  const WideSprite& s = kind.s;
  if (!(s.radius < Kind::kNarrow) || !(s.half < kLongest)) return kFull;
  const float reach = kind.reach();
  const Outline outline(s, reach);
  std::uint64_t sum = 0;
  const int far = 1 << 20;
  const Pixels rows = rows_of(s, reach, -far, far);
  for (int row = rows.first; row <= rows.last; ++row) {
    const float y = static_cast<float>(row) - s.y;
    const Pixels columns = columns_of(s, outline, y, -far, far);
    for (int x = columns.first; x <= columns.last; x += kWidth) {
      const Uints weight = weight_of(kind.measured(kind.glow(numbers_from(x) - s.x, all(y))), kFull, kFull);
      for (int lane = 0; lane < kWidth; ++lane) sum += x + lane <= columns.last ? weight[lane] : 0;
    }
  }
  if (sum == 0) return kFull;
  return kFull * (kind.total() * kFull / static_cast<float>(sum));
}

// All values of a vector of pixels to three lanes per pixel: lane l of vector j takes pixel (l + kWidth * j) / 3.
struct Spread3 {
#if MOTES_WIDTH >= 256
  Uints from[3];
#endif
};
MOTES_INLINE Spread3 spread3() {
  Spread3 s;
#if MOTES_WIDTH >= 256
  for (int j = 0; j < 3; ++j) {
    for (int lane = 0; lane < kWidth; ++lane) s.from[j][lane] = static_cast<std::uint32_t>((lane + kWidth * j) / 3);
  }
#endif
  return s;
}
MOTES_INLINE Uints spread(const Spread3& s, Uints pixels, int j) {
#if MOTES_WIDTH == 512
  return (Uints)_mm512_maskz_permutexvar_epi32(0xffff, (__m512i)s.from[j], (__m512i)pixels);
#elif MOTES_WIDTH == 256
  return (Uints)_mm256_permutevar8x32_epi32((__m256i)pixels, (__m256i)s.from[j]);
#else
  (void)s;
  const Uints p = pixels;
  return j == 0   ? Uints{p[0], p[0], p[0], p[1]}
         : j == 1 ? Uints{p[1], p[1], p[2], p[2]}
                  : Uints{p[2], p[3], p[3], p[3]};
#endif
}

// True in the lanes of a channel, for each of the three vectors.
struct ChannelMasks {
  Uints part[3][3];
};
MOTES_INLINE ChannelMasks channel_masks() {
  ChannelMasks m;
  for (int c = 0; c < 3; ++c) {
    for (int j = 0; j < 3; ++j) {
      for (int lane = 0; lane < kWidth; ++lane) m.part[c][j][lane] = (lane + kWidth * j) % 3 == c ? 0xffffffffu : 0u;
    }
  }
  return m;
}

// Weights of light and cover at a vector of pixels.
struct Weights {
  Uints cover, light[3];
};

template <bool kColored>
struct Drawing {
  Channels channel = channels();
  Spread3 spreading = spread3();
  ChannelMasks masks;

  MOTES_INLINE Drawing() {
    if constexpr (kColored) masks = channel_masks();
  }
  MOTES_INLINE Uints light(const Weights& w, int j) const {
    if constexpr (!kColored) return spread(spreading, w.light[0], j);
    return (spread(spreading, w.light[0], j) & masks.part[0][j]) |
           (spread(spreading, w.light[1], j) & masks.part[1][j]) |
           (spread(spreading, w.light[2], j) & masks.part[2][j]);
  }
};

MOTES_INLINE Weights hide(Weights w, Uints visible) {
  w.cover &= visible;
  for (Uints& light : w.light) light &= visible;
  return w;
}

template <class Kind, bool kOver, bool kSaturating>
MOTES_INLINE void draw_one(const TilePlanes& tile, const WideSplat& task, const WideSprite& s,
                           const Drawing<Kind::kColored>& drawing) {
  if (tile.hides && s.depth > tile.farthest) return;
  const Kind kind(task, s);
  const float reach = kind.reach();
  const bool test = tile.hides && (task.fade > 0 || s.depth > tile.nearest);
  const Pixels rows = rows_of(s, reach, 0, task.rows - 1);
  if (rows.first > rows.last) return;
  const float scale = scale_of(kind);
  const Outline outline(s, reach);
  const Light color = light_of(drawing.channel, s.color);
  const Uints alpha = all_uints(s.color >> 24);
  for (int row = rows.first; row <= rows.last; ++row) {
    const float y = static_cast<float>(row) - s.y;
    const Pixels columns = columns_of(s, outline, y, 0, task.columns - 1);
    for (int x = columns.first; x <= columns.last; x += kWidth) {
      const Glow glow = kind.glow(numbers_from(x) - s.x, all(y));
      Floats left = all(1.0f);
      Uints visible = ~Uints{};
      if (test) {
        const Uints wall = load_uints(tile.depth + static_cast<std::ptrdiff_t>(row) * kPixelStride + x);
        visible = (Uints)((Ints)wall >= (Ints)all_uints(s.depth));
        if (task.fade > 0) {
          left = clamp(((Floats)wall - (Floats)all_uints(s.depth)) * task.fade, 0, 1);
        }
      }
      Weights w;
      w.cover = weight_of(glow.cover * left, scale, kFull);
      for (int c = 0; c < 3; ++c) w.light[c] = weight_of(glow.light[c] * left, scale, kFull * image::kMostLight);
      w = hide(w, visible);
      std::uint32_t* to = tile.light + static_cast<std::ptrdiff_t>(row) * kLightStride + 3 * x;
      const int lanes = 3 * (columns.last - x + 1);
      for (int j = 0; j < 3 && j * kWidth < lanes; ++j) {
        const Uints more = (color.part[j] * drawing.light(w, j)) >> 8;
        Uints before = load_uints(to + j * kWidth);
        if (kOver) before = behind(before, opacity_of((alpha * spread(drawing.spreading, w.cover, j)) >> 8));
        Uints sum = before + more;
        if (kSaturating) sum |= (Uints)(sum < before);
        store_uints(to + j * kWidth, sum);
      }
    }
  }
}

template <class Kind, bool kOver, bool kSaturating>
void draw_all(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  const Drawing<Kind::kColored> drawing;
  for (std::size_t i = 0; i < count; ++i, records += task.record_bytes) {
    draw_one<Kind, kOver, kSaturating>(tile, task, sprite_from(task, records), drawing);
  }
}

template <class Kind>
void add_wide(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  task.saturating ? draw_all<Kind, false, true>(tile, task, records, count)
                  : draw_all<Kind, false, false>(tile, task, records, count);
}

template <class Kind>
void over_wide(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  task.saturating ? draw_all<Kind, true, true>(tile, task, records, count)
                  : draw_all<Kind, true, false>(tile, task, records, count);
}

MOTES_INLINE unsigned bits_of(Mask mask) {
#if MOTES_WIDTH == 512
  return _mm512_movepi32_mask((__m512i)mask);
#elif MOTES_WIDTH == 256
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
#elif MOTES_WIDTH == 128
  return static_cast<unsigned>(_mm_movemask_ps((__m128)mask));
#else
  unsigned bits = 0;
  for (int lane = 0; lane < kWidth; ++lane) bits |= static_cast<unsigned>(mask[lane] & 1) << lane;
  return bits;
#endif
}

template <class Kind>
void opaque_wide(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i, records += task.record_bytes) {
    const WideSprite s = sprite_from(task, records);
    const Kind kind(task, s);
    const float reach = kind.reach();
    const Floats center = (Floats)all_uints(s.depth);
    const Floats metres = center * all(task.radius);  // per pixel
    const Outline outline(s, reach);
    const Pixels rows = rows_of(s, reach, 0, task.rows - 1);
    for (int row = rows.first; row <= rows.last; ++row) {
      const float y = static_cast<float>(row) - s.y;
      const Pixels columns = columns_of(s, outline, y, 0, task.columns - 1);
      image::Nearest* to = tile.surfaces + static_cast<std::ptrdiff_t>(row) * kPixelStride;
      for (int x = columns.first; x <= columns.last; x += kWidth) {
        const Front front = kind.front(numbers_from(x) - s.x, all(y));
        const unsigned covered = bits_of(front.covered);
        if (covered == 0) continue;
        const Uints shade = (Uints)to_ints(clamp(front.shade * 255.0f, 1, 255) + 0.5f);
        const Uints surface = (front.color & 0xffffffu) | shade << 24;
        const Uints depth = (Uints)max(center - metres * front.nearer, all(kLeastDepth));
        keep_nearest(to + x, nearest_of(depth, surface, 0), covered);
        keep_nearest(to + x + kLongs, nearest_of(depth, surface, 1), covered >> kLongs);
      }
    }
  }
}

}  // namespace

extern const image::WideLanes wide_lanes = {{
#define MOTES_SPRITE_KIND(kind, Name) {add_wide<Name>, over_wide<Name>, opaque_wide<Name>},
#include "image/kinds/list.inc"
}};

}  // namespace motes::MOTES_ISA
