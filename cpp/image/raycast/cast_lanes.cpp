// Finds the surfaces that rays meet, and the light that they send to the eye.
#include "image/raycast/cast.h"

#include "image/grid.h"
#include "image/light/particle_lanes.h"
#include "image/project/screen_lanes.h"
#include "image/raycast/cast_glass.h"
#include "image/tile_planes.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {
namespace {

using image::CastSolid;
using image::CastView;

// Relative bias of a surface's depth: particles that rest on the surface count as in front of it.
constexpr float kBiasPixels = 3;  // how far a resting particle's disc reaches below its centre
constexpr float kLeastBias = 1.0f / 4096;
constexpr float kMostBias = 1.0f / 50;

constexpr float kCrease = 0.85f;  // an edge is smoothed if the cosine of the angle between normals is below this

MOTES_INLINE Ints load_ints(const std::uint32_t* from) { return (Ints)load_uints(from); }
MOTES_INLINE Ints choose(Mask mask, Ints yes, Ints no) { return (mask & yes) | (~mask & no); }

// Returns the directions of rays through points of the image; their view depth is 1 m.
MOTES_INLINE Floats3 directions(const CastView& view, const float* x, const float* y) {
  const Floats across = (load(x) - view.middle_x) * view.pixel;
  const Floats upward = (view.middle_y - load(y)) * view.pixel;
  return all3(view.forward) + all3(view.right) * across + all3(view.up) * upward;
}

MOTES_INLINE Floats3 load3(const float* const* planes, std::size_t i) {
  return {load(planes[0] + i), load(planes[1] + i), load(planes[2] + i)};
}
MOTES_INLINE void store3(float* const* planes, std::size_t i, Floats3 v) {
  store(planes[0] + i, v.x);
  store(planes[1] + i, v.y);
  store(planes[2] + i, v.z);
}

void cast(const CastView& view, const float* x, const float* y, std::size_t count, const image::Surfaces& to) {
  const Floats near = all(view.near);
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Rays rays{Floats3{}, directions(view, x + i, y + i)};
    Floats distance = all(__FLT_MAX__);
    Floats3 normal{};
    Ints surface{}, triangle{};
    for (const CastSolid* solid = view.solids; solid != view.solids + view.count; ++solid) {
      const RayHit crossing = find<true>(*solid, rays, near, distance);
      if (!any(crossing.met)) continue;
      distance = select(crossing.met, crossing.distance, distance);
      normal = select(crossing.met, unit(towards(normals(*solid, rays, crossing), rays)), normal);
      const Ints face = solid->nodes == nullptr ? crossing.face : Ints{};
      surface = choose(crossing.met, face + static_cast<std::int32_t>(1 + 4 * solid->number), surface);
      if (view.colored) triangle = choose(crossing.met, crossing.face, triangle);
    }
    store(to.distance + i, distance);
    store3(to.normal, i, normal);
    store_uints(to.surface + i, (Uints)surface);
    if (view.colored) store_uints(to.triangle + i, (Uints)triangle);
  }
}

MOTES_INLINE float least_of(Floats v) {
  float least = v[0];
  for (std::size_t i = 1; i < kLanes; ++i) least = v[i] < least ? v[i] : least;
  return least;
}

void measure(const CastView& view, const float* x, const float* y, std::size_t count, const image::Surfaces& from,
             image::Reach& reach, std::uint32_t* depth) {
  Floats3 low{all(__FLT_MAX__), all(__FLT_MAX__), all(__FLT_MAX__)}, high = -low;
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Mask seen = (load_ints(from.surface + i) != 0) & first_lanes(count - i);
    const Floats3 along = directions(view, x + i, y + i);
    const Floats distance = load(from.distance + i);
    const Floats3 point = along * distance;
    low = {min(low.x, select(seen, point.x, low.x)), min(low.y, select(seen, point.y, low.y)),
           min(low.z, select(seen, point.z, low.z))};
    high = {max(high.x, select(seen, point.x, high.x)), max(high.y, select(seen, point.y, high.y)),
            max(high.z, select(seen, point.z, high.z))};
    if (depth == nullptr) continue;
    // The steeper the depth changes across neighbouring pixels, the greater the bias.
    const Floats3 normal = load3(from.normal, i);
    const Floats across = abs(dot(normal, all3(view.right))) + abs(dot(normal, all3(view.up)));
    const Floats slope = across * view.pixel / abs(dot(normal, along));
    const Floats bias = min(kLeastBias + kBiasPixels * slope, all(kMostBias));
    const Floats hidden = select(seen, distance * (1.0f + bias), all(__builtin_inff()));
    store_uints(depth + i, (Uints)hidden);
  }
  const Floats lows[3] = {low.x, low.y, low.z}, highs[3] = {high.x, high.y, high.z};
  for (int axis = 0; axis < 3; ++axis) {
    const float least = least_of(lows[axis]), greatest = -least_of(-highs[axis]);
    reach.low[axis] = least < reach.low[axis] ? least : reach.low[axis];
    reach.high[axis] = greatest > reach.high[axis] ? greatest : reach.high[axis];
  }
}

void shade(const image::ShadeView& view, const float* x, const float* y, std::size_t count, const image::Surfaces& from,
           const image::Shades& to) {
  const bool plain = view.sky.kind == image::Sky::Kind::none;
  Floats3 background = all3(view.sky.color);
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Ints surface = load_ints(from.surface + i);
    Shading at{};
    at.seen = (surface != 0) & first_lanes(count - i);
    if (view.bare) {
      store3(to.light, i, Floats3{});
      store_uints(to.shadows + i, Uints{});
      continue;
    }
    if (!plain) background = sky_light(view.sky, directions(view.cast, x + i, y + i), first_lanes(count - i));
    if (!any(at.seen) && view.glass_count == 0) {
      store3(to.light, i, background);
      store_uints(to.shadows + i, Uints{});
      continue;
    }
    const Floats3 along = directions(view.cast, x + i, y + i);
    const Floats found = load(from.distance + i), distance = only(at.seen, found);
    at.point = along * distance;
    at.normal = load3(from.normal, i);
    at.offset = distance * 2e-5f + view.grain;
    at.object = (Ints)(((Uints)surface - 1u) >> 2);
    const Ints triangle = view.cast.colored ? load_ints(from.triangle + i) : Ints{};
    Floats3 light = background;
    if (any(at.seen)) {
      const Floats3 shown = light_sent(view, {along, distance, triangle}, at);
      light = select(at.seen, through_air(view, shown, distance, along, background), background);
    }
    if (view.glass_count != 0)
      add_glass(view, {along, found, triangle}, first_lanes(count - i), background, light, at.shadows);
    store3(to.light, i, light);
    store_uints(to.shadows + i, (Uints)at.shadows);
  }
}

// Rays start at the lit side of a particle, so a particle that rests on a solid is not shaded by it.
void in_sight(const image::ShadeView& view, const image::ShadedParticles& particles, const image::NearSolids& near,
              std::size_t first, std::size_t last, float* to, std::size_t stride) {
  static_assert(kLanes <= image::NearSolids::kMostLanes);
  const float spread = __builtin_sqrtf(view.sun_right[0] * view.sun_right[0] + view.sun_right[1] * view.sun_right[1] +
                                       view.sun_right[2] * view.sun_right[2]);
  const bool sized_sun = view.sun.shines && has_size(view);
  const Ints none = all_ints(-1);
  for (std::size_t i = first; i < last; i += kLanes) {
    const Floats3 place = particle_place(particles.planes, i);
    const Mask open = first_lanes(last - i) & finite(place);
    const Floats radius = diameter_at(particles.width, particles.planes, place, i) * 0.5f;
    Shading at{};
    at.point = only(open, place - all3(view.eye));
    at.object = none;
    at.offset = max(radius, length_of_way(at.point) * 2e-4f);
    float* const here = to + (i - first);
    const Floats3 sun = all3(view.sun.toward);
    Floats part = all(1.0f);
    if (sized_sun) {
      const Floats3 from = at.point + sun * at.offset;
      const Casters casters =
          near_cones({view.cast.solids, view.cast.count}, from, sun, all(__FLT_MAX__), 0, spread, open, near);
      part = sun_in_sight(view, from, at, open, casters);
    }
    store(here, part);
    for (std::size_t k = 0; k < view.light_count; ++k) {
      const image::CastLight& light = view.lights[k];
      part = all(1.0f);
      if (light.radius > 0) {
        const Floats3 from = at.point + unit(all3(light.position) - at.point) * at.offset;
        const Floats3 way = all3(light.position) - from;
        const Casters casters =
            near_cones({light.solids, light.count}, from, unit(way), sqrt(dot(way, way)), light.radius, 0, open, near);
        part = part_of_lamp(light, *view.places, from, at, open, casters);
      }
      store(here + (k + 1) * stride, part);
    }
  }
}

void slide(const CastView& view, const float* x, const float* y, const float* to_x, const float* to_y,
           std::size_t count, const image::Surfaces& surfaces) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Floats before = load(surfaces.distance + i);
    const Floats3 normal = load3(surfaces.normal, i);
    const Floats height = before * dot(normal, directions(view, x + i, y + i));
    const Floats after = height / dot(normal, directions(view, to_x + i, to_y + i));
    // Outside these bounds the plane is seen almost edge-on.
    const Mask good = (after > before * 0.8f) & (after < before * 1.25f);
    store(surfaces.distance + i, select(good, after, before));
  }
}

// Returns whether a pixel's mark, or its normal, differs from that of the pixel `step` further on.
MOTES_INLINE Mask edge_towards(const std::uint32_t* marks, const float* const* normal, std::ptrdiff_t at,
                               std::ptrdiff_t step) {
  const Uints here = load_uints(marks + at);
  Mask edge = (Mask)(here != load_uints(marks + at + step));
  if (normal != nullptr) {
    Floats cosine{};
    for (int axis = 0; axis < 3; ++axis) cosine += load(normal[axis] + at) * load(normal[axis] + at + step);
    edge |= (Mask)(here != 0) & (cosine < kCrease);
  }
  return edge;
}

std::size_t edges(const std::uint32_t* marks, const float* const* normal, int stride, int width, int height,
                  std::uint32_t* to) {
  std::size_t count = 0;
  Uints lane;
  for (std::size_t i = 0; i < kLanes; ++i) lane[i] = static_cast<std::uint32_t>(i);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; x += static_cast<int>(kLanes)) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y) * stride + x;
      const Mask edge = (edge_towards(marks, normal, at, -1) | edge_towards(marks, normal, at, 1) |
                         edge_towards(marks, normal, at, -stride) | edge_towards(marks, normal, at, stride)) &
                        first_lanes(static_cast<std::size_t>(width - x));
      if (!any(edge)) continue;
      count += squeeze(to + count, lane + static_cast<std::uint32_t>(image::kTile * y + x), edge);
    }
  }
  return count;
}

// Sums may exceed the range of signed integers, so their upper and lower halves are converted separately, both exactly.
MOTES_INLINE Uints to_sums(Floats light) {
  const Floats sums = min(light * static_cast<float>(image::kUnit) + 0.5f, all(image::kMostScenery));
  const Ints high = to_ints(sums * 0x1p-16f);
  return (Uints)high << 16 | (Uints)to_ints(sums - to_floats(high) * 0x1p16f);
}

void store_light(const float* const* light, std::size_t count, std::uint32_t* to) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    std::uint32_t part[3][kLanes];
    for (int c = 0; c < 3; ++c) store_uints(part[c], to_sums(load(light[c] + i)));
    const std::size_t here = count - i < kLanes ? count - i : kLanes;
    for (std::size_t lane = 0; lane < here; ++lane) {
      for (std::size_t c = 0; c < 3; ++c) to[3 * (i + lane) + c] = part[c][lane];
    }
  }
}

}  // namespace

extern const image::CastLanes cast_lanes = {cast, measure, shade, in_sight, slide, edges, store_light};

}  // namespace motes::MOTES_ISA
