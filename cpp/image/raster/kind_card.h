// card: a picture on a plane in space, seen from both sides.
#pragma once

#include "image/raster/kind_image.h"

namespace motes::MOTES_ISA {

/// The projection of a card. A pixel (x, y) px from the card's middle, y down, shows the point of the card (u, v) px to
/// the right of and below its middle. A px on the card is as long as one at the particle's depth, on a plane
/// that faces the camera.
///
///   u = (right_x x + right_y y) / (1 + tilt_x x + tilt_y y), v = (below_x x + below_y y) / (the same)
struct Stand {
  float right_x, right_y, below_x, below_y, tilt_x, tilt_y;
  float finer_x, finer_y;  // px on the screen per px along u and v, at the middle
  float area;              // square px on the card per square px on the screen, at the middle
  float shrink;            // 1 / area; 0: seen edge-on
  float x = 0, y = 0;      // offset of its middle from the sprite's, px
  float lens_x = 0, lens_y = 0;  // point on the lens from which it is seen: see see_from()

  MOTES_INLINE Stand(const CameraPose& p, float focal) {
    const float from_x = p.middle_x / focal, from_y = -p.middle_y / focal;  // direction (from_x, from_y, -1)
    const float ahead = p.front.x * from_x + p.front.y * from_y - p.front.z;
    seen = ahead > kEdge || ahead < -kEdge;
    const float per = seen ? 1 / (ahead * focal) : 0;
    tilt_x = p.front.x * per;
    tilt_y = -p.front.y * per;
    const float across = focal * (p.right.x * from_x + p.right.y * from_y - p.right.z);
    const float upward = focal * (p.up.x * from_x + p.up.y * from_y - p.up.z);
    right_x = p.right.x - tilt_x * across;
    right_y = -p.right.y - tilt_y * across;
    below_x = tilt_x * upward - p.up.x;
    below_y = p.up.y + tilt_y * upward;
    measure();
  }

  /// Moves it to where it appears from the point on the lens that moves infinitely distant points by (to_x, to_y) px.
  /// Points of the card move by (to_x, to_y) (1 - focus / depth), which is linear in their position.
  MOTES_INLINE void see_from(float to_x, float to_y, float focus, float inverse_depth) {
    const float near = focus * inverse_depth, moved = 1 - near;
    lens_x = to_x;
    lens_y = to_y;
    x += to_x * moved;
    y += to_y * moved;
    const float rest = 1 - near * (tilt_x * to_x + tilt_y * to_y), part = near / (rest > kEdge ? rest : kEdge);
    const float more_x = tilt_x * part, more_y = tilt_y * part;
    const auto take_back = [&](float& along_x, float& along_y) {
      const float by = along_x * to_x + along_y * to_y;
      along_x += more_x * by;
      along_y += more_y * by;
    };
    take_back(right_x, right_y);
    take_back(below_x, below_y);
    take_back(tilt_x, tilt_y);
    measure();
  }

  /// Enlarges the card.
  MOTES_INLINE void enlarge(float times) {
    const float part = 1 / times;
    for (float* number : {&right_x, &right_y, &below_x, &below_y, &tilt_x, &tilt_y}) *number *= part;
    finer_x *= times;
    finer_y *= times;
  }

  static constexpr float kBehind = 0.05f;  // parts nearer than this fraction of the depth are not drawn

 private:
  static constexpr float kEdge = 1e-3f;  // the cosine below which a card counts as seen edge-on

  bool seen;

  MOTES_INLINE void measure() {
    area = size_of(right_x * below_y - right_y * below_x);
    shrink = seen && area > 0 ? 1 / area : 0;
    finer_x = 1 / __builtin_sqrtf(right_x * right_x + right_y * right_y + 1e-12f);
    finer_y = 1 / __builtin_sqrtf(below_x * below_x + below_y * below_y + 1e-12f);
  }
};

struct Card : Picture<Card> {
  using Splat = image::CardSplat;
  static constexpr float kNarrow = 12;

  CameraPose pose;
  Stand middle;
  PosedMoments moments;
  Walls walls{};  // tested if there are moments
  float side;    // half of the longer side, px on the card
  float shrink;  // square px on the screen per square px on the card, at the middle; mean over the moments
  float half_x = 0, half_y = 0, farthest = 0;  // bounds on the corners, px on the screen

  MOTES_INLINE Card(const image::WideSplat& task, const WideSprite& sprite)
      : Card(task, task.own<Splat>(), sprite, CameraPose(task, sprite)) {}

  MOTES_INLINE bool tests_itself() const { return moments.count != 0; }
  MOTES_INLINE float reach() const { return farthest; }
  MOTES_INLINE float box_x() const { return half_x; }
  MOTES_INLINE float box_y() const { return half_y; }
  MOTES_INLINE float total() const { return 4 * side * side * shrink * cover * s.light; }
  MOTES_INLINE float usual_sum() const { return 4 * side * side * shrink * cover * kPixelWeight * finer + 1e-3f; }

  MOTES_INLINE void weigh(Patch<4>& p) const { moments.count == 0 ? weigh_still(p) : weigh_moments(p); }

  /// Turns an opaque card to where it is at a time of the shutter: its fronts are those of this moment from here on.
  MOTES_INLINE void turn_to(float time) {
    if (!pose.turns()) return;
    image::Moment moment{};
    moment.time = time;
    middle = Stand(pose.at(moment), focal);
    moments.count = 0;
  }

  /// Returns how many times nearer than the middle the card is at pixels, and 1 / the middle's depth.
  MOTES_INLINE Floats nearness(Floats x, Floats y) const { return above_horizon(middle, x, y); }
  MOTES_INLINE float inverse_depth() const { return 1 / pose.depth; }
  /// Returns a bound on how much more its nearest part is blurred than its middle; `blur`: radius at infinity, px.
  MOTES_INLINE float uneven(float blur_px) const {
    const float left = pose.depth - 0.7072f * pose.scale, least = Stand::kBehind * pose.depth;
    return blur_px * focus * (1 / (left > least ? left : least) - 1 / pose.depth);
  }

  MOTES_INLINE Front front(Floats x, Floats y) const {
    Front front = front_of(moments.count != 0 ? most_opaque_moment(x, y)
                           : moves            ? most_opaque(x, y)
                                              : texels(x, y),
                           x, y);
    front.nearer = clamp(focal * (1.0f - 1.0f / above_horizon(middle, x, y)), -s.radius, s.radius);
    return front;
  }

 private:
  friend struct Picture<Card>;

  float focal, focus, blur;
  float near_x = 0, near_y = 0;  // half of its bounding box at any one moment, px

  MOTES_INLINE Card(const image::WideSplat& common, const Splat& task, const WideSprite& sprite, const CameraPose& p)
      : Picture(common, task.picture, facing(task, sprite, p)), pose(p), middle(p, task.focal),
        moments(task, p, 0.7072f * p.scale, 2 * s.radius, s.half,
                s.half > 0 || task.blur > 0 || p.turns() ? common.memory.moments : nullptr),
        side(s.radius), shrink(middle.shrink), focal(task.focal), focus(task.focus), blur(task.blur) {
    const float opaque = choose_level(task.picture, side, middle.shrink > 0 ? __builtin_sqrtf(middle.area) : 1);
    const float wide = width * middle.finer_x, high = height * middle.finer_y;
    least = 0.5f * kPixelWeight * opaque * (wide < 1 ? wide : 1) * (high < 1 ? high : 1);
    moments.count == 0 ? measure(p, 1) : measure_moments();
    half_x += 1;
    half_y += 1;
    farthest += 1.5f;
    // No part of the card is nearer than its middle by more than half the diagonal of a square.
    s.radius *= 1.4143f;
    if (moments.count == 0) {
      choose_steps();
    } else if (s.radius < kNarrow) {
      s.radius = kNarrow;  // a mean over many moments needs no other normalisation
    }
  }

  static MOTES_INLINE WideSprite facing(const Splat& task, const WideSprite& sprite, const CameraPose& p) {
    WideSprite s = sprite;
    s.radius = 0.5f * p.scale * task.focal / p.depth;
    return s;
  }

  /// Extends the box to the corners of the card, which is drawn `larger` times as large.
  MOTES_INLINE void measure(const CameraPose& p, float larger) {
    for (int corner = 0; corner < 4; ++corner) {
      const float u = (corner & 1) != 0 ? 0.5f * width * larger : -0.5f * width * larger;
      const float v = (corner & 2) != 0 ? 0.5f * height * larger : -0.5f * height * larger;
      const float near = 1 - (p.right.z * u + p.up.z * v) / focal;
      const float part = 1 / (near > Stand::kBehind ? near : Stand::kBehind);
      const float x = size_of((p.middle_x + p.right.x * u + p.up.x * v) * part - p.middle_x);
      const float y = size_of((p.middle_y - p.right.y * u - p.up.y * v) * part - p.middle_y);
      const float distance = __builtin_sqrtf(x * x + y * y);
      half_x = half_x > x ? half_x : x;
      half_y = half_y > y ? half_y : y;
      farthest = farthest > distance ? farthest : distance;
    }
  }

  MOTES_INLINE void measure_moments() {
    float sum = 0;
    moments.for_each([&](int number, const image::Moment& m) {
      const CameraPose then = pose.at(m);
      if (number == 0 || pose.turns()) measure(then, moments.larger);
      sum += stand_at(then, m).shrink;
    });
    shrink = sum / static_cast<float>(moments.shown);
    near_x = half_x + moments.uneven + 2;
    near_y = half_y + moments.uneven + 2;
    for (float* size : {&half_x, &half_y, &farthest}) {
      *size += moments.blur;
      *size = *size < image::kMostPosedReach ? *size : image::kMostPosedReach;
    }
  }

  /// Returns the projection at a moment, without the motion along the streak.
  MOTES_INLINE Stand stand_at(const CameraPose& then, const image::Moment& m) const {
    Stand stand(then, focal);
    if (blur > 0) stand.see_from(m.lens_x * blur, m.lens_y * blur, focus, 1 / then.depth);
    return stand;
  }
  MOTES_INLINE Stand shown_at(const image::Moment& m) const {
    Stand stand = stand_at(pose.at(m), m);
    stand.x += m.time * pose.dx;
    stand.y += m.time * pose.dy;
    if (moments.larger > 1) stand.enlarge(moments.larger);
    return stand;
  }

  MOTES_INLINE SurfacePoint point(Floats x, Floats y) const {
    const Floats depth = pose.depth / above_horizon(middle, x, y), per = depth * (1 / focal);
    const Floats3 place{(x + pose.middle_x) * per, (y + pose.middle_y) * -per, -depth}, front = all3(pose.front);
    return {place, front * select(dot(front, place) > 0.0f, all(-1.0f), all(1.0f))};
  }

  static MOTES_INLINE Floats above_horizon(const Stand& at, Floats x, Floats y) {
    return max(x * at.tilt_x + y * at.tilt_y + 1.0f, all(Stand::kBehind));
  }

  MOTES_INLINE Texels texels(Floats x, Floats y) const { return texels_of(middle, x, y); }

  MOTES_INLINE Texels texels_of(const Stand& at, Floats x, Floats y) const {
    const Floats horizon = x * at.tilt_x + y * at.tilt_y + 1.0f;
    const Floats part = 1.0f / max(horizon, all(Stand::kBehind));
    const Floats to_right = (x * at.right_x + y * at.right_y) * part,
                 to_below = (x * at.below_x + y * at.below_y) * part;
    Texels t = texels_near(to_right, to_below);
    const Floats inside =
        covered(to_right * at.finer_x, width * at.finer_x) * covered(to_below * at.finer_y, height * at.finer_y);
    const Ints drawn = to_ints(only((horizon > Stand::kBehind) & (all(at.shrink) > 0.0f), inside) * 32768.0f + 0.5f);
    for (Ints& channel : t.channel) channel = channel * drawn >> 15;
    return t;
  }

  MOTES_OUTLINE Texels most_opaque_moment(Floats x, Floats y) const {
    Texels most{};
    moments.for_each([&](int, const image::Moment& m) {
      const Stand at = shown_at(m);
      const Texels t = texels_of(at, x - at.x, y - at.y);
      const Mask more = (Mask)(t.channel[3] > most.channel[3]);
      for (int c = 0; c < 4; ++c) most.channel[c] = select(more, t.channel[c], most.channel[c]);
    });
    return most;
  }

  /// Sums of weights, per pixel of a patch.
  struct Sums {
    std::int32_t channel[4][kPatchPixels + 64];
  };

  MOTES_OUTLINE void weigh_moments(Patch<4>& p) const {
    Sums sums;
    for (auto& plane : sums.channel) {
      __builtin_memset(plane, 0, sizeof plane[0] * static_cast<std::size_t>(kStrip * p.strips * p.stride + kLanes));
    }
    moments.for_each([&](int, const image::Moment& m) { add_moment(m, p, sums); });
    const float part = 1 / (static_cast<float>(moments.shown) * moments.larger * moments.larger);
    for_each_vector(p, [&](Floats x, Floats y, const InPart& in_part) {
      const int at = in_part.number(p);
      Texels mean;
      for (int c = 0; c < 4; ++c) mean.channel[c] = to_ints(to_floats(load_mask(sums.channel[c] + at)) * part + 0.5f);
      dress(mean, x - s.x, y - s.y);
      store_narrow(p.cover + at, mean.channel[3]);
      store_thirds(p.light + 3 * at, mean.channel[0], mean.channel[1], mean.channel[2]);
    });
  }

  /// Adds the card at one moment, visiting only the blocks (two rows of a strip) around it.
  MOTES_INLINE void add_moment(const image::Moment& m, const PatchPart& p, Sums& sums) const {
    const Stand stand = shown_at(m);
    const float x = s.x + stand.x, y = s.y + stand.y;
    const int above = floor_of(y - near_y) - p.first, below = floor_of(y + near_y) + 1 - p.first;
    const int left = floor_of(x - near_x) - kStrip, right = floor_of(x + near_x) + 1;
    for (int row = above > 0 ? above & ~1 : 0; row < p.rows && row <= below; row += 2) {
      const int one = p.start[row], other = p.start[row + 1 < p.rows ? row + 1 : row];
      const int least = one < other ? one : other, most = one < other ? other : one;
      for (int strip = 0; strip < p.strips; ++strip) {
        if (most + strip * kStrip < left || least + strip * kStrip > right) continue;
        for (int down = row; down < row + 2 && down < p.rows; down += kPixelRows) {
          for (int first = 0; first < kStrip; first += kWidth) add_vector(stand, p, InPart{strip, down, first}, sums);
        }
      }
    }
  }

  MOTES_INLINE void add_vector(const Stand& stand, const PatchPart& p, const InPart& in_part, Sums& sums) const {
    const PixelPositions at = place_of(p, in_part.strip, in_part.row, in_part.first);
    const Floats x = at.x - (s.x + stand.x), y = at.y - (s.y + stand.y);
    Texels t = texels_of(stand, x, y);
    if (walls.depth != nullptr && any(t.channel[3] > 0)) {
      const Floats depth = pose.depth / above_horizon(stand, x, y);
      Floats seen;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float moved = moments.one == nullptr ? 1 - focus / depth[lane] : 0;  // an exposure's walls are in place
        seen[lane] = walls.visible(at.x[lane] - stand.lens_x * moved, at.y[lane] - stand.lens_y * moved, depth[lane]);
      }
      for (Ints& channel : t.channel) channel = to_ints(to_floats(channel) * seen + 0.5f);
    }
    for (int c = 0; c < 4; ++c) {
      std::int32_t* const to = sums.channel[c] + in_part.number(p);
      store_mask(to, load_mask(to) + t.channel[c]);
    }
  }
};

}  // namespace motes::MOTES_ISA
