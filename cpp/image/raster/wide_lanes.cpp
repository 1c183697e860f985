// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/raster/wide_lanes.h"

#include <type_traits>

#include "image/all_kinds.h"
#include "image/grid.h"
#include "image/raster/disc_lanes.h"
#include "image/raster/exposed_lanes.h"
#include "image/raster/image_stamp_lanes.h"
#include "image/raster/stamp_lanes.h"

namespace motes::MOTES_ISA {
namespace {

using image::kPixelStride;
using image::TilePlanes;
using image::WideSplat;

// Narrow streaks of up to this half length, px, are weighed as a whole in each of their tiles, to normalise them. Along
// longer ones the sub-pixel position averages out, unless they stay within fewer than kStraight rows or columns; those
// are sampled at kSamples positions.
constexpr float kLongest = 512;
constexpr float kStraight = 12;
constexpr int kSamples = 32;

MOTES_INLINE void read_record(const WideSplat& task, const unsigned char* bytes, DiscGroup& g, int k) {
  const image::WideRecord r = record_of(task, bytes);
  g.record_x[k] = r.x;
  g.record_y[k] = r.y;
  __builtin_memcpy(g.color + k, r.color, sizeof g.color[k]);
  g.depth[k] = r.depth;
  g.size[k] = image::size_units(r.size);
  g.light[k] = r.light;
  g.dx[k] = r.dx;
  g.dy[k] = r.dy;
}

// Sum of the weights of all rows, and the greatest weight.
struct Weighed {
  std::uint64_t sum = 0;
  int most = 1;
};
MOTES_OUTLINE void count(const PatchPart& p, const std::uint16_t* weights, Weighed& all) {
  Uints sum{};
  Shorts most{};
  for (int strip = 0; strip < p.strips; ++strip, weights += p.stride * kStrip) {
    for (int row = 0; row < p.rows; row += kRowsAtOnce) {
      Shorts v;
      __builtin_memcpy(&v, weights + row * kStrip, sizeof v);
      v = rows_within(v, row, p.rows);
      sum += pair_sums(v);
      most = max_shorts(most, v);
    }
  }
  all.sum += sum_of(sum);
  const int here = greatest_of(most);
  all.most = here > all.most ? here : all.most;
}

template <class Kind>
MOTES_INLINE Weighed count_blocks(const Kind& kind, const Outline& o, Patch<Kind::kPlanes>& patch) {
  Weighed all;
  for (int row = o.first; row <= o.last; row += kPatchRows) {
    const int last = row + kPatchRows - 1 < o.last ? row + kPatchRows - 1 : o.last;
    for (int strip = 0; strip < o.strips; strip += kPatchStrips) {
      const int strips = o.strips - strip < kPatchStrips ? o.strips - strip : kPatchStrips;
      place_rows(patch, kind.s, o, row, last, strip, strips);
      kind.weigh(patch);
      count(patch, Kind::measured(patch), all);
    }
  }
  return all;
}

// Returns whether a sprite is so narrow that its sum of weights, which must be normalised, varies with the sub-pixel
// position.
template <class Kind>
MOTES_INLINE bool is_narrow(const Kind& kind) {
  if constexpr (requires { kind.is_narrow(); }) return kind.is_narrow();
  return kind.s.radius < Kind::kNarrow;
}

// Estimates the weights of a streak along a row or column from kSamples evenly spaced strips or rows. A streak has
// constant light except near its ends, where the light beyond them makes up for what is missing before them.
template <class Kind>
MOTES_INLINE Weighed count_samples(const Kind& kind, const Outline& o, Patch<Kind::kPlanes>& patch) {
  const WideSprite& s = kind.s;
  const bool along_row = size_of(s.along_x) > size_of(s.along_y);
  Weighed all;
  for (int i = 0; i < kSamples; ++i) {
    const float way = s.half * (static_cast<float>(2 * i + 1) / kSamples - 1);
    if (along_row) {
      const int strip = static_cast<int>((s.x + way * s.along_x - o.left) / kStrip);
      place_rows(patch, s, o, o.first, o.last, strip, 1);
    } else {
      const int row = floor_of(s.y + way * s.along_y) - kStrip / 2;
      place_rows(patch, s, o, row, row + kStrip - 1, 0, o.strips);
    }
    kind.weigh(patch);
    count(patch, Kind::measured(patch), all);
  }
  const float pixels = 2 * s.half * size_of(along_row ? s.along_x : s.along_y);
  all.sum = static_cast<std::uint64_t>(static_cast<float>(all.sum) * (pixels / (kSamples * kStrip)));
  return all;
}

// Weighs a sprite that is larger than a part; returns an empty result if its expected sum is accurate enough.
template <class Kind>
MOTES_INLINE Weighed count_large(const Kind& kind, const Outline& o, Patch<Kind::kPlanes>& patch) {
  const WideSprite& s = kind.s;
  if (!is_narrow(kind)) return {};
  if (s.half < kLongest) return count_blocks(kind, o, patch);
  const float slope = size_of(s.along_x) < size_of(s.along_y) ? s.along_x : s.along_y;
  return 2 * s.half * size_of(slope) < kStraight ? count_samples(kind, o, patch) : Weighed{};
}

// Returns the light of a weight of 1, such that the sum of weights gives the sprite's light.
template <class Kind>
MOTES_INLINE float unit_of(const Kind& kind, const Weighed& all) {
  const float unit = kind.total() / (all.sum > 0 ? static_cast<float>(all.sum) : kind.usual_sum());
  const float most = image::kMostLight / (all.sum > 0 ? static_cast<float>(all.most) : kind.greatest());
  return unit < most ? unit : most;
}

// Sets up the part of an outline that lies in the tile: rows first .. last.
MOTES_INLINE void place_in_tile(PatchPart& part, const WideSprite& s, const Outline& o, int first, int last,
                                int columns) {
  // Rows that follow a streak are narrow; all others begin at the same column.
  int from = 0, strips = o.strips;
  if (o.slope == 0) {
    const int left = floor_of(o.left) + 1, end = (columns - left + kStrip - 1) / kStrip;
    from = left < 0 ? -left / kStrip : 0;
    strips = (o.strips < end ? o.strips : end) - from;
  }
  place_rows(part, s, o, first, last, from, strips);
}

// Computes the weights in rows first .. last of the tile; returns the light of a weight of 1.
template <class Kind>
MOTES_INLINE float weigh(const Kind& kind, const Outline& o, int first, int last, int columns,
                         Patch<Kind::kPlanes>& patch) {
  const bool in_one_part = o.last - o.first < kPatchRows && o.strips <= kPatchStrips;
  if (in_one_part && is_narrow(kind)) {
    place_rows(patch, kind.s, o, o.first, o.last, 0, o.strips);
    kind.weigh(patch);
    Weighed all;
    count(patch, Kind::measured(patch), all);
    return unit_of(kind, all);
  }
  const float unit = unit_of(kind, count_large(kind, o, patch));
  place_in_tile(patch, kind.s, o, first, last, columns);
  kind.weigh(patch);
  return unit;
}

// Returns whether a sprite within a box of half width box_x lies beside the tile.
MOTES_INLINE bool beside(const WideSplat& task, const WideSprite& s, float box_x) {
  const float extent = box_x + s.half * size_of(s.along_x);
  return s.x + extent <= 0 || s.x - extent >= static_cast<float>(task.columns - 1);
}

// Draws rows first .. last of a patch, like draw_patch().
template <int kPlanes>
using PatchKernel = void(const TilePlanes& tile, const Patch<kPlanes>& patch, const Tint& tint, int first, int last,
                         int columns, std::uint32_t depth, float fade);

using StampKernel = void(const TilePlanes& tile, const WideSplat& task, const image::ImageStamp& stamp,
                         const Tint& tint, int column, int row, std::uint32_t depth);

// The inner loops of one blend, shared by all kinds of sprites.
struct Blend {
  int (*discs)(const TilePlanes& tile, const WideSplat& task, const DiscGroup& g, int i, int count);
  StreakKernels streaks;
  // Indexed by whether something may hide the sprite.
  PatchKernel<1>* shining[2];
  PatchKernel<2>* shaded[2];
  PatchKernel<4>* colored[2];
  StampKernel* stamp[2];

  template <int kPlanes>
  MOTES_INLINE PatchKernel<kPlanes>* patch(bool test) const {
    if constexpr (kPlanes == 1) return shining[test];
    if constexpr (kPlanes == 2) return shaded[test];
    if constexpr (kPlanes == 4) return colored[test];
  }
};

template <bool kOver, bool kSaturating>
constexpr Blend kBlend = {
    draw_discs<kOver, kSaturating>,
    {kOver, draw_queue<kOver, kSaturating>},
    {draw_patch<1, kOver, kSaturating, false>, draw_patch<1, kOver, kSaturating, true>},
    {draw_patch<2, kOver, kSaturating, false>, draw_patch<2, kOver, kSaturating, true>},
    {draw_patch<4, kOver, kSaturating, false>, draw_patch<4, kOver, kSaturating, true>},
    {draw_stamp<kOver, kSaturating, false>, draw_stamp<kOver, kSaturating, true>},
};

// Whether a kind of sprite can test its visibility at each pixel itself.
template <class Kind>
constexpr bool kHasWalls = requires(Kind kind) { kind.walls; };
template <class Kind>
MOTES_INLINE bool tests_itself(const Kind& kind) {
  if constexpr (kHasWalls<Kind>) return kind.tests_itself();
  return false;
}

template <class Kind>
__attribute__((noinline)) void draw_one(const TilePlanes& tile, const WideSplat& task, const WideSprite& sprite,
                                        const Channels& channel, const Blend& blend, Patch<Kind::kPlanes>& patch) {
  // Parts of a sprite in space that a lens blurs may be visible even if its middle is hidden.
  const bool deep = [&] {
    if constexpr (kHasWalls<Kind>) return task.own<typename Kind::Splat>().blur > 0;
    return false;
  }();
  if (!deep && tile.hides && sprite.depth > tile.farthest) return;
  Kind kind(task, sprite);
  if constexpr (kHasWalls<Kind>) kind.walls = {tile.hides ? tile.depth : nullptr, task.fade, task.columns, task.rows};
  const WideSprite& s = kind.s;
  const Outline o = outline_of(s, kind.reach(), kind.box_x(), kind.box_y());
  const int first = o.first > 0 ? o.first : 0, last = o.last < task.rows - 1 ? o.last : task.rows - 1;
  if (first > last || beside(task, s, kind.box_x())) return;
  const float unit = weigh(kind, o, first, last, task.columns, patch);
  Tint tint;
  if (!tint_of(channel, s.color, unit, tint)) return;
  const bool test = tile.hides && (task.fade > 0 || s.depth > tile.nearest) && !tests_itself(kind);
  blend.patch<Kind::kPlanes>(test)(tile, patch, tint, first, last, task.columns, s.depth, task.fade);
}

// Draws streaks of sprites of one size from stamps, and long ones one by one.
void draw_stamped(const TilePlanes& planes, const WideSplat& task, const unsigned char* records, std::size_t count,
                  const Blend& blend) {
  const TilePlanes tile = planes;
  const WideSplat t = task;
  const Channels channel = channels();
  StampUses uses;
  BlockQueue queue;
  DiscGroup g;
  Patch<1> patch;
  const auto bytes = static_cast<std::size_t>(t.record_bytes);
  for (std::size_t i = 0; i < count; i += kLanes, records += kLanes * bytes) {
    const int number = static_cast<int>(count - i < kLanes ? count - i : kLanes);
    const auto record = [&](int k) { return records + static_cast<std::size_t>(k) * bytes; };
    const Streaks streaks =
        number == kWidth ? read_streaks(t, [&](std::size_t k) { return records + k * bytes; })
                         : read_streaks(t, [&](std::size_t k) { return records + (k < count - i ? k : 0) * bytes; });
    draw_streaks(tile, t, streaks, number, uses, queue, g, channel, blend.streaks,
                 [&](int k) { draw_one<Disc>(tile, t, sprite_from(t, record(k)), channel, blend, patch); });
  }
}

// Draws discs and points in groups (DiscGroup), and large ones one by one.
void draw_groups(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count,
                 const Blend& blend) {
  const Channels channel = channels();
  DiscGroup g;
  Patch<1> patch;
  const auto bytes = static_cast<std::size_t>(task.record_bytes);
  for (std::size_t i = 0; i < count; i += kLanes) {
    const int number = static_cast<int>(count - i < kLanes ? count - i : kLanes);
    const unsigned char* first = records + i * bytes;
    for (int k = 0; k < number; ++k) read_record(task, first + static_cast<std::size_t>(k) * bytes, g, k);
    prepare(g, tile, task, number);
    weigh(g, number);
    for (int k = blend.discs(tile, task, g, 0, number); k < number; k = blend.discs(tile, task, g, k + 1, number)) {
      const WideSprite s = sprite_from(task, first + static_cast<std::size_t>(k) * bytes);
      draw_one<Disc>(tile, task, s, channel, blend, patch);
    }
  }
}

// Computes the stamp of an image that is not opaque.
__attribute__((noinline)) void fill(const WideSplat& task, const WideSprite& sprite, const SmallImage& small,
                                    Patch<4>& patch, image::ImageStamp& stamp) {
  const Image kind(task, small.stamped(sprite));
  place_stamp(kind, patch, stamp);
  kind.weigh(patch);
  Weighed all;
  count(patch, patch.cover, all);
  if (all.sum == 0) stamp.rows = 0;
  stamp.share = all.sum > 0 ? kind.cover / static_cast<float>(all.sum) : 0;
  stamp.most = image::kMostLight / static_cast<float>(all.most);
  for (int strip = 0; strip < patch.strips; ++strip) {
    const int from = kStrip * strip * patch.stride, to = kStrip * strip * image::ImageStamp::kRows;
    __builtin_memcpy(stamp.weights.cover + to, patch.cover + from, sizeof(std::uint16_t) * kStrip * patch.rows);
    __builtin_memcpy(stamp.weights.light + 3 * to, patch.light + 3 * from,
                     3 * sizeof(std::uint16_t) * kStrip * patch.rows);
  }
}

// Draws a small image that does not move from its stamp; returns whether it is one.
MOTES_INLINE bool draw_small(const TilePlanes& tile, const WideSplat& task, const unsigned char* bytes,
                             const Channels& channel, const Blend& blend, Patch<4>& patch, Directed& directed) {
  const image::WideRecord r = record_of(task, bytes);
  if (!has_stamp(task, r)) return false;
  if (tile.hides && r.depth > tile.farthest) return true;
  const SmallImage small(task, r, bytes, directed, 0);
  bool there;
  image::ImageStamp& stamp = small.stamp(task, there);
  if (!there) fill(task, sprite_from(task, bytes), small, patch, stamp);
  const float width = static_cast<float>(r.size) * (1.0f / (1 << image::kSizeBits));
  const float unit = width * width * (static_cast<float>(r.light) * (1.0f / image::kAllLight)) * stamp.share;
  std::uint32_t color;
  __builtin_memcpy(&color, r.color, sizeof color);
  Tint tint;
  if (!tint_of(channel, color, unit < stamp.most ? unit : stamp.most, tint)) return true;
  const bool test = tile.hides && (task.fade > 0 || r.depth > tile.nearest);
  blend.stamp[test](tile, task, stamp, tint, small.column, small.row, r.depth);
  return true;
}

template <class Kind>
void draw_all(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count,
              const Blend& blend) {
  if constexpr (Kind::kPlanes == 1) {
    task.own<typename Kind::Splat>().one_size ? draw_stamped(tile, task, records, count, blend)
                                              : draw_groups(tile, task, records, count, blend);
  } else if constexpr (std::is_same_v<Kind, Image>) {
    const Channels channel = channels();
    Patch<Kind::kPlanes> patch;
    Directed directed;
    for (std::size_t i = 0; i < count; ++i, records += task.record_bytes) {
      if (draw_small(tile, task, records, channel, blend, patch, directed)) continue;
      draw_one<Kind>(tile, task, sprite_from(task, records), channel, blend, patch);
    }
  } else {
    const Channels channel = channels();
    Patch<Kind::kPlanes> patch;
    for (std::size_t i = 0; i < count; ++i, records += task.record_bytes) {
      draw_one<Kind>(tile, task, sprite_from(task, records), channel, blend, patch);
    }
  }
}

// Whether sprites of a kind need coloured light, which another kind of kernel computes.
template <class Kind>
MOTES_INLINE bool has_colors(const WideSplat& task) {
  if constexpr (std::is_same_v<Kind, Mesh>) {
    return task.light != nullptr || task.own<image::MeshSplat>().colors != nullptr;
  }
  return std::is_same_v<Kind, Sphere> && task.light != nullptr;
}
template <class Kind>
using Colored = std::conditional_t<std::is_same_v<Kind, Mesh>, ColoredMesh,
                                   std::conditional_t<std::is_same_v<Kind, Sphere>, LitSphere, Kind>>;

template <class Kind>
void add_wide(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  if constexpr (!std::is_same_v<Kind, Colored<Kind>>) {
    if (has_colors<Kind>(task)) return add_wide<Colored<Kind>>(tile, task, records, count);
  }
  draw_all<Kind>(tile, task, records, count, task.saturating ? kBlend<false, true> : kBlend<false, false>);
}

template <class Kind>
void over_wide(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  if constexpr (!std::is_same_v<Kind, Colored<Kind>>) {
    if (has_colors<Kind>(task)) return over_wide<Colored<Kind>>(tile, task, records, count);
  }
  draw_all<Kind>(tile, task, records, count, task.saturating ? kBlend<true, true> : kBlend<true, false>);
}

// Keeps the nearest surface at the covered pixels of a vector.
MOTES_INLINE void keep_vector(const TilePlanes& tile, const PatchPart& part, const InPart& at, unsigned covered,
                              Longs first, Longs second) {
  const auto keep = [&](int row, int column, unsigned bits, Longs nearest) {
    column += part.start[row] + at.strip * kStrip;
    if (bits == 0 || row >= part.rows || column <= -kStrip || column >= image::kTile) return;
    keep_nearest(tile.surfaces + static_cast<std::ptrdiff_t>(part.first + row) * kPixelStride + column, nearest, bits);
  };
  keep(at.row, at.first, covered & ((1u << kLongs) - 1), first);
  keep(at.row + kLongs / kStrip, at.first + kLongs % kStrip, covered >> kLongs, second);
}

// Draws opaque sprites that know their depth at each pixel.
template <class Kind>
void opaque_in_depth(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  if constexpr (!std::is_same_v<Kind, Colored<Kind>>) {
    if (has_colors<Kind>(task)) return opaque_in_depth<Colored<Kind>>(tile, task, records, count);
  }
  for (std::size_t i = 0; i < count; ++i, records += task.record_bytes) {
    const Kind kind(task, sprite_from(task, records));
    const WideSprite& s = kind.s;
    const Outline o = outline_of(s, kind.reach(), kind.box_x(), kind.box_y());
    const int first = o.first > 0 ? o.first : 0, last = o.last < task.rows - 1 ? o.last : task.rows - 1;
    if (first > last || beside(task, s, kind.box_x())) continue;
    const float extent_x = kind.box_x() + s.half * size_of(s.along_x);
    if (!is_hidden(tile, s, extent_x, first, last, kind.front_depth())) kind.draw(tile);
  }
}

// Draws a small opaque image that does not move from its stamp; returns whether it is one.
MOTES_INLINE bool draw_small_opaque(const TilePlanes& tile, const WideSplat& task, const unsigned char* bytes,
                                    Directed& directed) {
  const image::WideRecord r = record_of(task, bytes);
  if (!has_stamp(task, r)) return false;
  const SmallImage small(task, r, bytes, directed, SmallImage::kOpaque);
  bool there;
  image::ImageStamp& stamp = small.stamp(task, there);
  if (!there) fill_opaque(task, sprite_from(task, bytes), small, stamp);
  draw_opaque_stamp(tile, task, stamp, r, small);
  return true;
}

template <class Kind>
void opaque_wide(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  if constexpr (!std::is_same_v<Kind, Colored<Kind>>) {
    if (has_colors<Kind>(task)) return opaque_wide<Colored<Kind>>(tile, task, records, count);
  }
  PatchPart part;
  [[maybe_unused]] Directed directed;  // NOLINT(misc-const-correctness): images change it
  for (std::size_t i = 0; i < count; ++i, records += task.record_bytes) {
    if constexpr (std::is_same_v<Kind, Image>) {
      if (draw_small_opaque(tile, task, records, directed)) continue;
    }
    const Kind kind(task, sprite_from(task, records));
    const WideSprite& s = kind.s;
    const Outline o = outline_of(s, s.radius > kind.reach() ? s.radius : kind.reach(), kind.box_x(), kind.box_y());
    const int first = o.first > 0 ? o.first : 0, last = o.last < task.rows - 1 ? o.last : task.rows - 1;
    if (first > last || beside(task, s, kind.box_x())) continue;
    const Floats center = (Floats)all_uints(s.depth);
    const Floats metres = center * all(task.radius);  // per pixel
    const float extent_x = kind.box_x() + s.half * size_of(s.along_x);
    if (is_hidden(tile, s, extent_x, first, last, center[0] - metres[0] * s.radius)) continue;
    place_in_tile(part, s, o, first, last, task.columns);
    for_each_vector(part, [&](Floats x, Floats y, const InPart& at) {
      Front front;
      if constexpr (std::is_same_v<Kind, LitSphere>) {
        front = kind.front(x - s.x, y - s.y, [&](Mask there, Floats nearer) {
          return may_show(tile, part, at, there, max(center - metres * nearer, all(kLeastDepth)));
        });
      } else {
        front = kind.front(x - s.x, y - s.y);
      }
      const unsigned covered = bits_of(front.covered);
      if (covered == 0) return;
      const Uints depth = (Uints)max(center - metres * front.nearer, all(kLeastDepth));
      keep_vector(tile, part, at, covered, nearest_of(depth, front.surface, 0), nearest_of(depth, front.surface, 1));
    });
  }
}

template <class Kind>
void exposed_wide(const TilePlanes& tile, const WideSplat& task, const unsigned char* records, std::size_t count) {
  if constexpr (!std::is_same_v<Kind, Colored<Kind>>) {
    if (has_colors<Kind>(task)) return exposed_wide<Colored<Kind>>(tile, task, records, count);
  }
  for (std::size_t i = 0; i < count; ++i, records += task.record_bytes) {
    expose_all<Kind>(task, sprite_from(task, records));
  }
}

template <class Kind>
constexpr image::WideKernel* kOpaque = opaque_wide<Kind>;
template <>
constexpr image::WideKernel* kOpaque<Mesh> = opaque_in_depth<Mesh>;
template <>
constexpr image::WideKernel* kOpaque<Ribbon> = opaque_in_depth<Ribbon>;

}  // namespace

#define MOTES_SPRITE_KIND(kind, Name) static_assert(std::is_same_v<Name::Splat, image::Name##Splat>);
#include "image/sprites/list.inc"

extern const image::WideLanes wide_lanes = {{
#define MOTES_SPRITE_KIND(kind, Name) {add_wide<Name>, over_wide<Name>, kOpaque<Name>, exposed_wide<Name>},
#include "image/sprites/list.inc"
                                            },
                                            show_cover};

}  // namespace motes::MOTES_ISA
