// Triangles of meshes on the screen. Compiled once for each instruction set.
#pragma once

#include <cstdint>

#include "image/layout.h"
#include "simd/floats3.h"

namespace motes::image {
struct TextureLevel;
}

namespace motes::MOTES_ISA {

/// A triangle on the screen. Its corners are in 1/256 px right of and below the centre of the tile's first pixel, and
/// ordered so that its area is positive.
struct Facet {
  std::int64_t x[3], y[3];
  /// 1/depth at the first corner, its change per px to the right and down, and its bounds, 1/m.
  float inverse, right, down, least, most;
  float shade;
  bool swapped;  // the second and third corner are in reverse order
};

/// A triangle whose corners have colours. A colour divided by the depth is linear on the screen: `first` is its value
/// at the first corner, `to_right` and `to_below` its changes per px. `low` and `high` bound the colour.
struct TintedFacet : Facet {
  float first[3], to_right[3], to_below[3], low[3], high[3];
  Float3 normal;   // of the visible side, in the camera's axes
  bool small;      // `passes` is the same at all of its points
  Float3 passes[2];  // factor on its colour, and what is added to it, if there is light
  float inverses[3];  // 1/depth of its corners, if they have any of the following
  Float3 normals[3];  // at its corners, in the camera's axes
  float uv[6];        // places of its corners on `level`, a picture
  const image::TextureLevel* level;
};

/// The unit of corners on the screen, px.
inline constexpr float kFacetPixel = 1.0f / (1 << image::kWideBits);

/// A corner of a vector of triangles.
struct FacetCorner {
  Floats x, y;  // px from the centre of the tile's first pixel
  Floats inverse;  // 1/depth
  Mask in_front;
};

MOTES_INLINE float clamped(float v, float low, float high) { return v < low ? low : v > high ? high : v; }

/// Returns 1/depth at a position relative to a triangle's first corner, px.
MOTES_INLINE float inverse_at(const Facet& f, float right, float down) {
  return clamped(f.inverse + f.right * right + f.down * down, f.least, f.most);
}

/// Returns the distance from a triangle's first corner to its centre along an axis, px.
MOTES_INLINE float to_centre(const std::int64_t (&v)[3]) {
  return static_cast<float>(v[1] + v[2] - 2 * v[0]) * (kFacetPixel / 3);
}

/// Computes a triangle's corners and depths; returns false if it has no area.
MOTES_INLINE bool set_facet(const FacetCorner (&c)[3], std::size_t lane, Facet& f) {
  const auto place = [](float v) { return static_cast<std::int64_t>(floor_of(v * (1 << image::kWideBits) + 0.5f)); };
  float inverse[3];
  for (int k = 0; k < 3; ++k) {
    f.x[k] = place(c[k].x[lane]);
    f.y[k] = place(c[k].y[lane]);
    inverse[k] = c[k].inverse[lane];
  }
  std::int64_t area = (f.x[1] - f.x[0]) * (f.y[2] - f.y[0]) - (f.x[2] - f.x[0]) * (f.y[1] - f.y[0]);
  if (area == 0) return false;
  f.swapped = area < 0;
  if (f.swapped) {
    const std::int64_t x = f.x[1], y = f.y[1];
    const float of = inverse[1];
    f.x[1] = f.x[2], f.y[1] = f.y[2], inverse[1] = inverse[2];
    f.x[2] = x, f.y[2] = y, inverse[2] = of;
    area = -area;
  }
  const float per = 1 / (static_cast<float>(area) * kFacetPixel);  // of differences in 1/256 px
  const auto x = [&](int k) { return static_cast<float>(f.x[k] - f.x[0]); };
  const auto y = [&](int k) { return static_cast<float>(f.y[k] - f.y[0]); };
  const float one = inverse[1] - inverse[0], two = inverse[2] - inverse[0];
  f.inverse = inverse[0];
  f.right = (one * y(2) - two * y(1)) * per;
  f.down = (two * x(1) - one * x(2)) * per;
  f.least = f.most = inverse[0];
  for (int k = 1; k < 3; ++k) {
    f.least = f.least < inverse[k] ? f.least : inverse[k];
    f.most = f.most > inverse[k] ? f.most : inverse[k];
  }
  return true;
}

/// Returns the parts, 0..1, of a triangle's corners in the surface at a position relative to the first one, px.
MOTES_INLINE Float3 parts_at(const TintedFacet& f, float right, float down) {
  const float x1 = static_cast<float>(f.x[1] - f.x[0]) * kFacetPixel,
              y1 = static_cast<float>(f.y[1] - f.y[0]) * kFacetPixel;
  const float x2 = static_cast<float>(f.x[2] - f.x[0]) * kFacetPixel,
              y2 = static_cast<float>(f.y[2] - f.y[0]) * kFacetPixel;
  const float per = 1 / (x1 * y2 - x2 * y1);
  const float second = (right * y2 - down * x2) * per, third = (down * x1 - right * y1) * per;
  const auto part = [&](float on_screen, int k) { return on_screen > 0 ? on_screen * f.inverses[k] : 0; };
  const Float3 parts{part(1 - second - third, 0), part(second, 1), part(third, 2)};
  return times(parts, 1 / (parts.x + parts.y + parts.z));
}

/// Calls put(column, row) for each sample of a grid within a triangle moved by (dx, dy): kSamples x kSamples of them
/// per pixel, in `columns` x `rows` pixels. A sample on an edge belongs to one of the two triangles that share it.
/// kPitch: px between the samples of kSamples = 1.
template <int kSamples, int kPitch = 1, class Put>
MOTES_INLINE void for_each_sample(const Facet& f, std::int64_t dx, std::int64_t dy, int columns, int rows,
                                  const Put& put) {
  constexpr std::int64_t kStep = kPitch * (1 << image::kWideBits) / kSamples;
  constexpr std::int64_t kFirst = -(kSamples - 1) * kStep / 2;
  static_assert(kPitch == 1 || kSamples == 1);
  const auto least = [](const std::int64_t* v) {
    const std::int64_t a = v[0] < v[1] ? v[0] : v[1];
    return a < v[2] ? a : v[2];
  };
  const auto most = [](const std::int64_t* v) {
    const std::int64_t a = v[0] > v[1] ? v[0] : v[1];
    return a > v[2] ? a : v[2];
  };
  // Steps are powers of two: shifts round down.
  const auto from = [&](std::int64_t low) {
    const std::int64_t at = (low - kFirst + kStep - 1) >> __builtin_ctzll(kStep);
    return at > 0 ? at : 0;
  };
  const auto to = [&](std::int64_t high, std::int64_t count) {
    const std::int64_t at = (high - kFirst) >> __builtin_ctzll(kStep);
    return at < count - 1 ? at : count - 1;
  };
  const std::int64_t left = from(least(f.x) + dx), right = to(most(f.x) + dx, std::int64_t{columns} * kSamples);
  const std::int64_t first = from(least(f.y) + dy), last = to(most(f.y) + dy, std::int64_t{rows} * kSamples);
  if (left > right || first > last) return;
  std::int64_t edge[3], across[3], below[3];
  for (int k = 0; k < 3; ++k) {
    const int next = k == 2 ? 0 : k + 1;
    const std::int64_t way_x = f.x[next] - f.x[k], way_y = f.y[next] - f.y[k];
    const std::int64_t x = left * kStep + kFirst - f.x[k] - dx, y = first * kStep + kFirst - f.y[k] - dy;
    const bool own = way_y > 0 || (way_y == 0 && way_x < 0);
    edge[k] = way_x * y - way_y * x - (own ? 0 : 1);
    across[k] = -way_y * kStep;
    below[k] = way_x * kStep;
  }
  for (std::int64_t row = first; row <= last; ++row) {
    std::int64_t a = edge[0], b = edge[1], c = edge[2];
    for (std::int64_t column = left; column <= right; ++column) {
      if ((a | b | c) >= 0) put(static_cast<int>(column), static_cast<int>(row));
      a += across[0];
      b += across[1];
      c += across[2];
    }
    for (int k = 0; k < 3; ++k) edge[k] += below[k];
  }
}

}  // namespace motes::MOTES_ISA
