// card: a picture on a plane in space, seen from both sides.
#pragma once

#include "image/raster/kind_image.h"

namespace motes::MOTES_ISA {

/// Pixels (x, y) from the particle, y down, lie (u, v) px to the right and below the picture's middle, measured on the
/// card, of which a metre has as many px as one at the particle's depth that faces the camera:
///
///   u = (right_x x + right_y y) / (1 + tilt_x x + tilt_y y), v = (below_x x + below_y y) / (the same)
struct Card : Picture<Card> {
  static constexpr float kNarrow = 12;

  float right_x, right_y, below_x, below_y, tilt_x, tilt_y;
  float finer_x, finer_y;  // px on the screen per px along u and v, at the middle
  float shrink;            // screen's area of a square on the card, at the middle; 0: seen from the edge
  float side;              // half of the longer side, px on the card
  float half_x, half_y, farthest;  // around the corners, px on the screen

  MOTES_INLINE Card(const image::WideSplat& task, const WideSprite& sprite) : Card(task, sprite, Pose(task, sprite)) {}

  MOTES_INLINE float reach() const { return farthest; }
  MOTES_INLINE float box_x() const { return half_x; }
  MOTES_INLINE float box_y() const { return half_y; }
  MOTES_INLINE float total() const { return 4 * side * side * shrink * cover * s.light; }
  MOTES_INLINE float usual_sum() const { return 4 * side * side * shrink * cover * kPixelWeight * finer + 1e-3f; }

  MOTES_INLINE Front front(Floats x, Floats y) const {
    Front front = front_of(moves ? most_opaque(x, y) : texels(x, y));
    front.nearer = clamp(focal * (1.0f - 1.0f / above_horizon(x, y)), -s.radius, s.radius);
    return front;
  }

 private:
  friend struct Picture<Card>;

  float focal;

  MOTES_INLINE Card(const image::WideSplat& task, const WideSprite& sprite, const Pose& p)
      : Picture(task, facing(task, sprite, p)), side(s.radius), focal(task.focal) {
    const float from_x = p.middle_x / focal, from_y = -p.middle_y / focal;  // to the particle: (from_x, from_y, -1)
    const float ahead = p.front.x * from_x + p.front.y * from_y - p.front.z;
    const bool seen = ahead > kEdge || ahead < -kEdge;
    const float per = seen ? 1 / (ahead * focal) : 0;
    tilt_x = p.front.x * per;
    tilt_y = -p.front.y * per;
    const float across = focal * (p.right.x * from_x + p.right.y * from_y - p.right.z);
    const float upward = focal * (p.up.x * from_x + p.up.y * from_y - p.up.z);
    right_x = p.right.x - tilt_x * across;
    right_y = -p.right.y - tilt_y * across;
    below_x = tilt_x * upward - p.up.x;
    below_y = p.up.y + tilt_y * upward;
    const float area = size_of(right_x * below_y - right_y * below_x);
    shrink = seen && area > 0 ? 1 / area : 0;
    finer_x = 1 / __builtin_sqrtf(right_x * right_x + right_y * right_y + 1e-12f);
    finer_y = 1 / __builtin_sqrtf(below_x * below_x + below_y * below_y + 1e-12f);
    const float opaque = choose_level(task, side, shrink > 0 ? __builtin_sqrtf(area) : 1);
    const float wide = width * finer_x, high = height * finer_y;
    least = 0.5f * kPixelWeight * opaque * (wide < 1 ? wide : 1) * (high < 1 ? high : 1);
    measure(p);
    // Nothing of the card is nearer than its middle by more than this: half the diagonal of a square.
    s.radius *= 1.4143f;
    choose_steps();
  }

  static constexpr float kEdge = 1e-3f;  // the cosine below which a card is seen from its edge

  static MOTES_INLINE WideSprite facing(const image::WideSplat& task, const WideSprite& sprite, const Pose& p) {
    WideSprite s = sprite;
    s.radius = 0.5f * p.scale * task.focal / p.depth;
    return s;
  }

  MOTES_INLINE void measure(const Pose& p) {
    half_x = half_y = farthest = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const float u = (corner & 1) != 0 ? 0.5f * width : -0.5f * width;
      const float v = (corner & 2) != 0 ? 0.5f * height : -0.5f * height;
      const float near = 1 - (p.right.z * u + p.up.z * v) / focal;
      const float part = 1 / (near > kBehind ? near : kBehind);
      const float x = size_of((p.middle_x + p.right.x * u + p.up.x * v) * part - p.middle_x);
      const float y = size_of((p.middle_y - p.right.y * u - p.up.y * v) * part - p.middle_y);
      const float distance = __builtin_sqrtf(x * x + y * y);
      half_x = half_x > x ? half_x : x;
      half_y = half_y > y ? half_y : y;
      farthest = farthest > distance ? farthest : distance;
    }
    half_x += 1;
    half_y += 1;
    farthest += 1.5f;
  }

  static constexpr float kBehind = 0.05f;  // part of the depth; what is nearer is not drawn

  MOTES_INLINE Floats above_horizon(Floats x, Floats y) const {
    return max(x * tilt_x + y * tilt_y + 1.0f, all(kBehind));
  }

  MOTES_INLINE Texels texels(Floats x, Floats y) const {
    const Floats horizon = x * tilt_x + y * tilt_y + 1.0f;
    const Floats part = 1.0f / max(horizon, all(kBehind));
    const Floats to_right = (x * right_x + y * right_y) * part, to_below = (x * below_x + y * below_y) * part;
    Texels t = texels_near(to_right, to_below);
    const Floats inside = covered(to_right * finer_x, width * finer_x) * covered(to_below * finer_y, height * finer_y);
    const Ints drawn = to_ints(only((horizon > kBehind) & (all(shrink) > 0.0f), inside) * 32768.0f + 0.5f);
    for (Ints& channel : t.channel) channel = channel * drawn >> 15;
    return t;
  }
};

}  // namespace motes::MOTES_ISA
