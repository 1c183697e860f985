// ribbon: a band along a particle's past positions.
#pragma once

#include "image/raster/wide_sprite.h"
#include "image/ribbon_spline.h"

namespace motes::MOTES_ISA {

/// The ribbon's line is divided into straight pieces. Each pixel shows one point of the ribbon: of neighbouring pieces,
/// that in which the pixel lies deepest, so that pieces join without cracks or overlap; where the ribbon crosses
/// itself, the most opaque point, or the nearest one if the ribbon is opaque.
struct Ribbon {
  using Splat = image::RibbonSplat;
  static constexpr int kPlanes = 4;
  static constexpr float kNarrow = 0;

  WideSprite s;
  const image::WideSplat& task;
  const Splat& camera;
  Walls walls{};

  MOTES_INLINE Ribbon(const image::WideSplat& t, const WideSprite& sprite)
      : s(sprite), task(t), camera(t.own<Splat>()), exposed(t.memory.exposed != nullptr),
        blur(exposed ? t.memory.exposed->blur : camera.blur) {
    image::RibbonRecord r;
    __builtin_memcpy(&r, s.record, sizeof r);
    const int points = static_cast<int>(r.count) < kMostPoints ? static_cast<int>(r.count) : kMostPoints;
    r.count = static_cast<std::uint32_t>(points);
    run = points > 1 ? static_cast<float>(r.up_y) * image::kRunUnit : 0;
    const float scale = r.width * camera.focal;
    add(r.point[0], scale, r.point[0], 0, {r.point[0].x, r.point[0].y});
    for (int k = 0; k + 1 < points; ++k) {
      const image::RibbonSpan span = image::ribbon_span(r, k);
      const int pieces = pieces_of(span);
      for (int i = 1; i <= pieces; ++i) {
        const float part = static_cast<float>(i) / static_cast<float>(pieces);
        add(r.point[k], scale, r.point[k + 1], part, i == pieces ? span.to : span.at(part));
      }
    }
    if (joints == 1) repeat_first();
    measure();
  }
  MOTES_INLINE bool tests_itself() const { return true; }
  MOTES_INLINE float reach() const { return half_x > half_y ? half_x : half_y; }
  MOTES_INLINE float box_x() const { return half_x; }
  MOTES_INLINE float box_y() const { return half_y; }
  MOTES_INLINE float total() const { return s.light; }
  static MOTES_INLINE float greatest() { return kPixelWeight; }
  static MOTES_INLINE float usual_sum() { return kPixelWeight; }
  static MOTES_INLINE const std::uint16_t* measured(const Patch<4>& p) { return p.cover; }
  /// Returns the least depth of any part of it, m.
  MOTES_INLINE float front_depth() const {
    float depth;
    __builtin_memcpy(&depth, &s.depth, sizeof depth);
    return depth;
  }

  MOTES_OUTLINE void weigh(Patch<4>& p) const {
    const auto pixels = static_cast<std::size_t>(kStrip * p.strips * p.stride);
    __builtin_memset(p.cover, 0, sizeof p.cover[0] * pixels);
    __builtin_memset(p.light, 0, sizeof p.light[0] * 3 * pixels);
    Cells cells;
    const int first = p.first > 0 ? p.first : 0, last = p.first + p.rows - 1;
    for_each_time([&](const Time& time) {
      fill<false>(time, first, last < task.rows - 1 ? last : task.rows - 1, cells);
      for_each_shown(cells,
                     [&](int row, int column, int j, float part) { put(p, row, column, cells, j, part, time.dither); });
    });
  }

  /// Keeps the nearest surface at the centres of the tile's pixels.
  MOTES_OUTLINE void draw(const image::TilePlanes& tile) const {
    for_each_time([&](const Time& time) { keep(tile.surfaces, time); });
  }

  /// Keeps the nearest surfaces of each exposure; all phases show those of the first.
  MOTES_OUTLINE void expose(const image::ExposedTile& to) const {
    for (int number = 0; number < image::kExposures; ++number) {
      const image::Exposure& e = to.exposures->of[number][0];
      keep(to.surfaces[number], {0.5f - e.time, e.lens_x, e.lens_y, 0.5f, -e.pixel_x, -e.pixel_y});
    }
  }

 private:
  static constexpr int kMostPoints = static_cast<int>(image::kMostPast) + 1, kMostPieces = 8, kMostSteps = 16;
  static constexpr int kMostJoints = kMostPieces * (kMostPoints - 1) + 2;
  static constexpr int kRowNumbers = image::kTile + kWidth;
  static constexpr float kApart = 1e9f, kFarOut = 1e6f;

  // Ends of pieces, from the particle backwards.
  int joints = 0, steps = 1;
  float x[kMostJoints], y[kMostJoints];  // px from the centre of the tile's first pixel
  float move_x[kMostJoints], move_y[kMostJoints];  // px to where it was when the shutter opened
  float half[kMostJoints];  // of the width, px
  float inverse[kMostJoints];  // 1/depth, 1/m
  float left[kMostJoints];  // fraction of the ribbon's length behind the joint
  float tint[3][kMostJoints];  // factors on the colour
  float path[kMostJoints];  // distance along the line, px
  float spread[kMostJoints];  // blur radius, px, with its sign
  float half_x, half_y;
  float run;        // fraction of the length that the head travelled while the shutter was open
  bool simple;      // there is no lens blur
  float least = 0;  // least half width, px: narrower parts are drawn this wide, and fainter
  float dim = 1;    // factor on its light, if parts are drawn wider
  bool exposed;     // its exposures are drawn
  float blur;       // as SpaceSplat::blur

  // A time, and a point on the lens.
  struct Time {
    float part;            // 0: the shutter closes; 1: it opens
    float lens_x, lens_y;  // on a lens of radius 1
    float dither;          // see image::Moment
    float shift_x = 0, shift_y = 0;  // px
  };

  template <class Use>
  MOTES_INLINE void for_each_time(const Use& use) const {
    if (simple) {
      for (int step = 0; step < steps; ++step)
        use(Time{(static_cast<float>(step) + 0.5f) / static_cast<float>(steps), 0, 0, 0.5f});
      return;
    }
    image::for_each_moment(
        steps, [&](int, const image::Moment& m) { use(Time{0.5f - m.time, m.lens_x, m.lens_y, m.dither}); });
  }

  // The point of the ribbon that each pixel of the tile shows.
  struct Cells {
    int first, last;  // rows in use
    float score[image::kTile][kRowNumbers];   // its opacity, or 1/depth if the ribbon is opaque; 0: none
    float place[image::kTile][kRowNumbers];   // its position, in joints
    float inside[image::kTile][kRowNumbers];  // distance of the pixel from the ribbon's edge, px
    float path[image::kTile][kRowNumbers];    // distance along the line, px
  };

  // Keeps the nearest surfaces at one time.
  MOTES_INLINE void keep(image::NearestSurface* surfaces, const Time& time) const {
    Cells cells;
    const int first = floor_of(s.y - half_y), last = floor_of(s.y + half_y) + 1;
    fill<true>(time, first > 0 ? first : 0, last < task.rows - 1 ? last : task.rows - 1, cells);
    for_each_shown(cells, [&](int row, int column, int j, float part) {
      const float depth = 1 / between(inverse[j], inverse[j + 1], part);
      std::uint32_t bits, surface = 0xff000000u;
      __builtin_memcpy(&bits, &depth, sizeof bits);
      for (int c = 0; c < 3; ++c) {
        const float full = between(tint[c][j], tint[c][j + 1], part) * static_cast<float>(s.color >> (8 * c) & 0xffu);
        surface |= static_cast<std::uint32_t>(full + 0.5f) << (8 * c);
      }
      image::NearestSurface& there = surfaces[static_cast<std::ptrdiff_t>(row) * image::kPixelStride + column];
      const image::NearestSurface here = image::NearestSurface{bits} << 32 | surface;
      there = here < there ? here : there;
    });
  }

  // A straight piece at one time.
  struct Segment {
    float x, y, way_x, way_y, per_square;
    float half, half_more, left, left_more, inverse, inverse_more, path, path_more;
    float lens_x, lens_y;  // shift of infinitely distant points, px
  };

  // Clamps a coordinate, because a curve may swing far out.
  static MOTES_INLINE float within(float v) { return v > -kFarOut ? (v < kFarOut ? v : kFarOut) : -kFarOut; }
  static MOTES_INLINE float between(float from, float to, float part) { return from + (to - from) * part; }

  static MOTES_INLINE int pieces_of(const image::RibbonSpan& span) {
    const float across = span.to.x - span.from.x, down = span.to.y - span.from.y;
    const float square = across * across + down * down;
    return square < 4 * 4 ? 1 : square < 12 * 12 ? 2 : square < 40 * 40 ? 4 : kMostPieces;
  }

  MOTES_INLINE void add(const image::RibbonPoint& a, float scale, const image::RibbonPoint& b, float part,
                        const image::OnScreen& at) {
    const int j = joints++;
    constexpr float kUnit = 1.0f / (1 << image::kWideBits), kSixteenth = 1.0f / 16;
    x[j] = within(at.x) - static_cast<float>(task.origin_x) * kUnit;
    y[j] = within(at.y) - static_cast<float>(task.origin_y) * kUnit;
    move_x[j] = between(a.then_x, b.then_x, part) * kSixteenth;
    move_y[j] = between(a.then_y, b.then_y, part) * kSixteenth;
    inverse[j] = between(1 / a.depth, 1 / b.depth, part);
    const float along = between(a.along, b.along, part);
    half[j] = image::ribbon_half(scale, inverse[j], along);
    left[j] = 1 - along;
    spread[j] = image::spread_at(blur, camera.focus, inverse[j]);
    spread[j] = spread[j] > -image::kMostPosedReach ? spread[j] : -image::kMostPosedReach;
    spread[j] = spread[j] < image::kMostPosedReach ? spread[j] : image::kMostPosedReach;
    const int before = j > 0 ? j - 1 : 0;
    const float way_x = x[j] - x[before], way_y = y[j] - y[before];
    path[j] = j > 0 ? path[before] + __builtin_sqrtf(way_x * way_x + way_y * way_y) : 0;
    for (int c = 0; c < 3; ++c) tint[c][j] = between(a.tint[c], b.tint[c], part) * (1.0f / 255);
  }

  // Duplicates the only joint of a particle without past positions, which is then drawn as a disc.
  MOTES_INLINE void repeat_first() {
    joints = 2;
    x[1] = x[0], y[1] = y[0], move_x[1] = move_x[0], move_y[1] = move_y[0];
    half[1] = half[0], inverse[1] = inverse[0], left[1] = left[0], path[1] = path[0], spread[1] = spread[0];
    for (float (&channel)[kMostJoints] : tint) channel[1] = channel[0];
  }

  // Computes the bounding box, whose middle becomes that of the sprite, and the steps of its motion.
  MOTES_INLINE void measure() {
    choose_times();
    float left_x = x[0], right_x = x[0], top = y[0], bottom = y[0];
    const auto include = [&](float at_x, float at_y, float wide) {
      left_x = at_x - wide < left_x ? at_x - wide : left_x;
      right_x = at_x + wide > right_x ? at_x + wide : right_x;
      top = at_y - wide < top ? at_y - wide : top;
      bottom = at_y + wide > bottom ? at_y + wide : bottom;
    };
    for (int j = 0; j < joints; ++j) {
      float wide = half[j] > 0 ? half[j] : 0;
      if (!simple) {
        wide = (wide > least ? wide : least) + size_of(spread[j]);
      }
      wide += 1;
      include(x[j], y[j], wide);
      include(x[j] + move_x[j], y[j] + move_y[j], wide);
    }
    s.x = 0.5f * (left_x + right_x);
    s.y = 0.5f * (top + bottom);
    half_x = 0.5f * (right_x - left_x) + 1;
    half_y = 0.5f * (bottom - top) + 1;
    s.half = 0;
    s.radius = half_x > half_y ? half_x : half_y;
  }

  // Chooses the number of times and points on the lens.
  MOTES_INLINE void choose_times() {
    float moved = 0, widest = 0;
    for (int j = 0; j < joints; ++j) {
      const float way = size_of(move_x[j]) + size_of(move_y[j]);
      moved = way > moved ? way : moved;
      widest = widest > size_of(spread[j]) ? widest : size_of(spread[j]);
    }
    simple = !(blur > 0);
    while (steps < kMostSteps && static_cast<float>(steps) < moved) steps *= 2;
    if (simple) return;
    if (exposed) return;
    steps = image::moments_for(moved, 2 * widest, image::kFewestMoments);
    least = 0.5f * image::lens_gap(2 * widest, steps);
    dim_ends();
  }

  // Widening a ribbon lengthens its round ends, too: dims all of it, so that its light stays.
  MOTES_INLINE void dim_ends() {
    float body = 0;
    for (int j = 0; j + 1 < joints; ++j) {
      const float ends = half[j] * left[j] + half[j + 1] * left[j + 1];
      const float crossed = half[j] * left[j + 1] + half[j + 1] * left[j];
      const float mean = (2 * ends + crossed) * (1.0f / 3);  // of two linear functions, twice
      body += mean > 0 ? mean * (path[j + 1] - path[j]) : 0;
    }
    float own = body, wide = body;
    for (const int j : {0, joints - 1}) {
      const float fade = left[j];
      if (!(half[j] > 0) || !(fade > 0)) continue;
      own += end_light(half[j]) * fade;
      wide += half[j] < least ? end_light(least) * (half[j] / least) * fade : end_light(half[j]) * fade;
    }
    dim = wide > 0 ? own / wide : 1;
  }
  // Returns the light of half a disc with this radius, px^2, whose edge is as soft as in show().
  static MOTES_INLINE float end_light(float radius) {
    const float most = radius < 0.5f ? 2 * radius : 1, inner = radius + 0.5f - most, outer = radius + 0.5f;
    const float ramp =
        outer * outer * outer * (1.0f / 6) - 0.5f * outer * inner * inner + inner * inner * inner * (1.0f / 3);
    return 3.14159265f * (0.5f * most * inner * inner + ramp);
  }

  MOTES_INLINE Segment piece_of(int k, const Time& time) const {
    const float part = time.part;
    Segment p;
    p.x = x[k] + move_x[k] * part + time.shift_x;
    p.y = y[k] + move_y[k] * part + time.shift_y;
    float end_x = x[k + 1] + move_x[k + 1] * part + time.shift_x;
    float end_y = y[k + 1] + move_y[k + 1] * part + time.shift_y;
    if (!simple) {
      p.x += time.lens_x * spread[k];
      p.y += time.lens_y * spread[k];
      end_x += time.lens_x * spread[k + 1];
      end_y += time.lens_y * spread[k + 1];
    }
    p.way_x = end_x - p.x;
    p.way_y = end_y - p.y;
    const float square = p.way_x * p.way_x + p.way_y * p.way_y;
    p.per_square = square > 1e-12f ? 1 / square : 0;
    p.half = half[k];
    p.half_more = half[k + 1] - half[k];
    p.left = left[k];
    p.left_more = left[k + 1] - left[k];
    p.inverse = inverse[k];
    p.inverse_more = inverse[k + 1] - inverse[k];
    p.path = path[k];
    p.path_more = path[k + 1] - path[k];
    p.lens_x = time.lens_x * blur;
    p.lens_y = time.lens_y * blur;
    return p;
  }

  /// Calls use(piece, row, column, along, from) for each vector of pixels near piece `k` in rows first .. last.
  /// `along`: position, 0..1, of the piece's point nearest to a pixel; `from`: its distance from the pixel, px.
  template <class Use>
  MOTES_INLINE void for_each_place(int k, const Time& time, int first, int last, const Use& use) const {
    const Segment p = piece_of(k, time);
    float wide = (half[k] > half[k + 1] ? half[k] : half[k + 1]) + 1;
    if (!(wide > 1)) return;
    wide = wide > least + 1 ? wide : least + 1;
    const auto low = [&](float at, float way) { return floor_of((way < 0 ? at + way : at) - wide) + 1; };
    const auto high = [&](float at, float way) { return floor_of((way > 0 ? at + way : at) + wide); };
    const int above = low(p.y, p.way_y), below = high(p.y, p.way_y);
    int column = low(p.x, p.way_x), right = high(p.x, p.way_x);
    column = column > 0 ? column : 0;
    right = right < task.columns - 1 ? right : task.columns - 1;
    for (int row = above > first ? above : first; row <= (below < last ? below : last); ++row) {
      const float down = static_cast<float>(row) - p.y;
      for (int at = column; at <= right; at += kWidth) {
        const Floats across = numbers_from(at) - p.x;
        const Floats along = clamp((across * p.way_x + down * p.way_y) * p.per_square, 0, 1);
        const Floats aside_x = across - along * p.way_x, aside_y = down - along * p.way_y;
        use(p, row, at, along, sqrt(aside_x * aside_x + aside_y * aside_y));
      }
    }
  }

  /// Finds the points that pixels in rows first .. last show. kOpaque: pixels are either covered or not.
  template <bool kOpaque>
  MOTES_INLINE void fill(const Time& time, int first, int last, Cells& cells) const {
    cells.first = first;
    cells.last = last;
    for (int row = first; row <= last; ++row) {
      __builtin_memset(cells.score[row], 0, sizeof cells.score[0]);
      for (int column = 0; column < kRowNumbers; column += kWidth) store(cells.path[row] + column, all(-kApart));
    }
    for (int k = 0; k + 1 < joints; ++k) {
      for_each_place(k, time, first, last, [&](const Segment& piece, int row, int column, Floats along, Floats from) {
        show<kOpaque>(piece, k, along, from, cells, row, column);
      });
    }
  }

  template <bool kOpaque>
  MOTES_INLINE void show(const Segment& piece, int k, Floats along, Floats from, Cells& cells, int row,
                         int column) const {
    const Floats own = piece.half + piece.half_more * along, half = max(own, all(least));
    const Floats inside = (kOpaque ? max(half, all(0.5f)) : half) - from, left = piece.left + piece.left_more * along;
    Floats score;
    if (kOpaque) {
      score = only((inside >= 0.0f) & (own > 0.0f), piece.inverse + piece.inverse_more * along);
    } else {
      const Floats covered = clamp(min(inside + 0.5f, half * 2.0f), 0, 1);
      score = covered * max(left, Floats{});
      // A point counts only for the fraction of the time after the head has passed it.
      if (run > 0) score = score * clamp((1.0f - left) * (1 / run), 0, 1);
      if (least > 0) score = only(own > 0.0f, score * (own / half) * dim);
      if (walls.depth != nullptr) score = score * visible(piece, row, column, along);
    }
    float* const scores = cells.score[row] + column;
    float* const places = cells.place[row] + column;
    float* const insides = cells.inside[row] + column;
    float* const paths = cells.path[row] + column;
    const Floats score_before = load(scores), path_before = load(paths);
    const Floats here = piece.path + piece.path_more * along;
    const Mask neighbour = here - path_before < half * 4.0f + 2.0f;
    const Mask deeper = inside > load(insides);
    Mask more = (score > 0.0f) & ((neighbour & deeper) | (~neighbour & (score > score_before)));
    if (!kOpaque && least > 0) more |= neighbour & deeper & (inside > -0.5f);  // beyond its end, a wide one has none
    store(scores, select(more, score, score_before));
    store(places, select(more, along + static_cast<float>(k), load(places)));
    store(insides, select(more, inside, load(insides)));
    store(paths, select(more, here, path_before));
  }

  /// Calls use(row, column, joint, part) for each pixel that shows the ribbon, `part` of the way from a joint to the
  /// next one.
  template <class Use>
  MOTES_INLINE void for_each_shown(const Cells& cells, const Use& use) const {
    for (int row = cells.first; row <= cells.last; ++row) {
      for (int column = 0; column < task.columns; ++column) {
        if (!(cells.score[row][column] > 0)) continue;
        const auto k = static_cast<int>(cells.place[row][column]);
        const int j = k < joints - 2 ? k : joints - 2;
        use(row, column, j, cells.place[row][column] - static_cast<float>(j));
      }
    }
  }

  // Adds a pixel to the weights of a patch.
  MOTES_INLINE void put(Patch<4>& p, int row, int column, const Cells& cells, int j, float part, float round) const {
    const int down = row - p.first, right = column - p.start[down];
    if (static_cast<unsigned>(right) >= static_cast<unsigned>(kStrip * p.strips)) return;
    const int at = kStrip * (right / kStrip * p.stride + down) + right % kStrip;
    const int weight = static_cast<int>(cells.score[row][column] * (kPixelWeight / static_cast<float>(steps)) + round);
    const int room = static_cast<int>(kPixelWeight) - p.cover[at], more = weight < room ? weight : room;
    p.cover[at] = static_cast<std::uint16_t>(p.cover[at] + more);
    for (int c = 0; c < 3; ++c) {
      const float light = static_cast<float>(more) * between(tint[c][j], tint[c][j + 1], part);
      p.light[3 * at + c] = static_cast<std::uint16_t>(p.light[3 * at + c] + static_cast<int>(light + 0.5f));
    }
  }

  /// Returns the part of the ribbon, 0..1, that is visible in front of the nearest surfaces at a vector of pixels.
  MOTES_INLINE Floats visible(const Segment& piece, int row, int column, Floats along) const {
    const Floats inverse_depth = piece.inverse + piece.inverse_more * along;
    if (blur > 0) {
      Floats part;
      for (int lane = 0; lane < kWidth; ++lane) {
        const float moved = image::spread_at(1, camera.focus, inverse_depth[lane]);
        part[lane] = walls.visible(static_cast<float>(column + lane) - piece.lens_x * moved,
                                   static_cast<float>(row) - piece.lens_y * moved, 1 / inverse_depth[lane]);
      }
      return part;
    }
    const Floats wall =
        (Floats)load_uints(walls.depth + static_cast<std::ptrdiff_t>(row) * image::kPixelStride + column);
    const Floats room = wall - 1.0f / inverse_depth;
    if (!(task.fade > 0)) return only(room >= 0.0f, all(1.0f));
    return clamp(room * task.fade, 0, 1);
  }
};

}  // namespace motes::MOTES_ISA
