// The smooth line through a ribbon's points. Everything is always inlined, because files compiled once for each
// instruction set use it.
#pragma once

#include "image/layout.h"

#define MOTES_ALWAYS inline __attribute__((always_inline))

namespace motes::image {

struct OnScreen {
  float x, y;  // px
};

/// A cubic Bezier curve between two consecutive points of a ribbon. It lies in the convex hull of its control points.
struct RibbonSpan {
  OnScreen from, leaving, arriving, to;

  MOTES_ALWAYS OnScreen at(float part) const {
    const float rest = 1 - part, a = rest * rest * rest, b = 3 * rest * rest * part, c = 3 * rest * part * part;
    const float d = part * part * part;
    return {from.x * a + leaving.x * b + arriving.x * c + to.x * d,
            from.y * a + leaving.y * b + arriving.y * c + to.y * d};
  }
};

/// Returns the derivative of a ribbon's line at a point, px per length of the ribbon: that of a parabola through the
/// point and its neighbours (a Catmull-Rom spline whose knots are times), so points at unequal times leave no kinks.
MOTES_ALWAYS OnScreen ribbon_tangent(const RibbonRecord& r, int i) {
  const int last = static_cast<int>(r.count) - 1;
  const auto rate = [&](int from) {
    const RibbonPoint &a = r.point[from], &b = r.point[from + 1];
    const float time = b.along - a.along, per = time > 0 ? 1 / time : 0;
    return OnScreen{(b.x - a.x) * per, (b.y - a.y) * per};
  };
  if (i == 0) return rate(0);
  if (i == last) return rate(last - 1);
  const float before = r.point[i].along - r.point[i - 1].along, after = r.point[i + 1].along - r.point[i].along;
  const float sum = before + after, per = sum > 0 ? 1 / sum : 0;
  const OnScreen one = rate(i - 1), other = rate(i);
  return {(one.x * after + other.x * before) * per, (one.y * after + other.y * before) * per};
}

/// Returns the curve from point `i` to point i + 1.
MOTES_ALWAYS RibbonSpan ribbon_span(const RibbonRecord& r, int i) {
  const RibbonPoint &a = r.point[i], &b = r.point[i + 1];
  const OnScreen leaving = ribbon_tangent(r, i), arriving = ribbon_tangent(r, i + 1);
  const float third = (b.along - a.along) * (1.0f / 3);
  return {{a.x, a.y},
          {a.x + leaving.x * third, a.y + leaving.y * third},
          {b.x - arriving.x * third, b.y - arriving.y * third},
          {b.x, b.y}};
}

/// Returns half of a ribbon's width, px, at a depth of 1 / `inverse` m: negative beyond its end, and at most
/// kMostPosedReach. `scale`: its width, m, times the focal length, px.
MOTES_ALWAYS float ribbon_half(float scale, float inverse, float along) {
  const float half = 0.5f * scale * inverse * (1 - along);
  if (half < -kMostPosedReach) return -kMostPosedReach;
  return half < kMostPosedReach ? half : kMostPosedReach;
}

}  // namespace motes::image

#undef MOTES_ALWAYS
