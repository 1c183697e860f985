// The part of a light that opaque particles let through, from its depth map. Compiled once for each instruction set.
#pragma once

#include "image/light/depth_map.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// Positions in a map.
struct InDepthMap {
  Ints plane;
  Floats column, row;  // texels
  Floats depth;  // m
  Floats texel;  // width of a texel there, m
  Mask known;    // the map reaches them
};

MOTES_INLINE InDepthMap in_sun_map(const image::DepthSpace& space, Floats3 offset, Mask known) {
  constexpr float kFirst = image::kDepthMargin + 2, kLast = image::kDepthSide - kFirst;
  const Floats x = dot(offset, all3(space.right)) * space.texels, y = dot(offset, all3(space.up)) * space.texels;
  InDepthMap at{Ints{}, Floats{}, Floats{}, dot(offset, all3(space.ahead)), all(1 / space.texels), Mask{}};
  float part = 1;
  for (int plane = 0; plane < image::kSunPlanes; ++plane, part *= 0.5f) {
    const Floats column = x * part - space.first[plane][0], row = y * part - space.first[plane][1];
    const Mask inside = known & ~at.known & (column >= kFirst) & (column <= kLast) & (row >= kFirst) & (row <= kLast);
    at.plane = (inside & all_ints(plane)) | (~inside & at.plane);
    at.column = select(inside, column, at.column);
    at.row = select(inside, row, at.row);
    at.texel = select(inside, all(1 / (space.texels * part)), at.texel);
    at.known |= inside;
  }
  return at;
}

MOTES_INLINE InDepthMap in_lamp_map(Floats3 offset, Mask known) {
  const Floats3 far{abs(offset.x), abs(offset.y), abs(offset.z)};
  const Mask by_x = (far.x >= far.y) & (far.x >= far.z), by_y = ~by_x & (far.y >= far.z);
  const auto choose = [&](Floats x, Floats y, Floats z) { return select(by_x, x, select(by_y, y, z)); };
  const Floats along = choose(offset.x, offset.y, offset.z), depth = abs(along);
  known &= depth > 1e-6f;
  const Floats per = image::kFaceTexels / select(known, depth, all(1.0f));
  constexpr float kMiddle = image::kDepthSide / 2;
  const Ints face = (by_y & all_ints(2)) | (~by_x & ~by_y & all_ints(4));
  return {(face - (along < 0.0f)) & known,
          only(known, choose(offset.y, offset.z, offset.x) * per + kMiddle),
          only(known, choose(offset.z, offset.x, offset.y) * per + kMiddle),
          depth,
          depth * (1 / image::kFaceTexels),
          known};
}

/// Returns the pages at places of a plane, numbered as in DepthView::texels.
MOTES_INLINE Floats page_at(const image::DepthView& map, Ints plane, Ints column, Ints row) {
  const Ints page = (plane * image::kDepthPages + (row >> 6)) * image::kDepthPages + (column >> 6);
  static_assert(image::kDepthPage == 1 << 6);
  return gather(map.pages, page);
}
MOTES_INLINE Ints texel_of(Floats place) { return to_ints(min(max(place, Floats{}), all(image::kDepthSide - 0.5f))); }

/// Returns minus the depth at places of a plane.
MOTES_INLINE Floats nearness_at(const image::DepthView& map, const InDepthMap& at, Floats right, Floats below) {
  const Ints column = texel_of(at.column + right), row = texel_of(at.row + below);
  const Ints first = to_ints(page_at(map, at.plane, column, row)) << 12;
  return gather(map.texels, first + ((row & 63) << 6) + (column & 63));
}

/// Returns whether anything may be within `radius` texels of any of the places.
MOTES_INLINE bool any_near(const image::DepthView& map, const InDepthMap& at, Floats radius) {
  Mask found{};
  for (const float x : {-1.0f, 1.0f}) {
    for (const float y : {-1.0f, 1.0f}) {
      const Ints column = texel_of(at.column + radius * x), row = texel_of(at.row + radius * y);
      found |= page_at(map, at.plane, column, row) > 0.0f;
    }
  }
  return any(found & at.known);
}

/// Returns the radius, texels, of the filter that gives shadows the edges of a light with a size: by the mean depth of
/// what blocks it near a place (R. Fernando 2005). `search`: where that is looked for, texels.
MOTES_INLINE Floats edge_radius(const image::DepthView& map, const InDepthMap& at, Floats limit, float search) {
  Floats sum{}, count{};
  for (int k = 0; k < image::DepthTaps::kAll; ++k) {
    const Floats here = nearness_at(map, at, all(map.taps->x[k] * search), all(map.taps->y[k] * search));
    const Mask blocks = here > limit;
    sum += only(blocks, here);
    count += only(blocks, all(1.0f));
  }
  const Floats blocker = -sum / max(count, all(1.0f));
  const Floats wide = map.space.size * (at.depth - blocker);
  return only(count > 0.0f, map.space.point ? wide / max(blocker, all(1e-6f)) : wide) / at.texel;
}

/// Returns the part of a light that arrives at places, as a mean over `wide` m around them. What is less than `back` m
/// nearer to the light, along the map's depth, does not count.
__attribute__((noinline)) inline Floats light_past(const image::DepthView& map, Floats3 place, Floats back,
                                                   Floats wide) {
  using image::DepthTaps;
  constexpr float kLeast = 1.25f, kMost = image::kDepthMargin;  // radius of a filter, texels
  constexpr float kReach = 1600;  // greatest distance of a blocker from what it shades, texels of the first plane
  Floats3 offset = place - all3(map.space.origin);
  const Mask sane = finite(offset);
  offset = only(sane, offset);
  InDepthMap at = map.space.point ? in_lamp_map(offset, sane) : in_sun_map(map.space, offset, sane);
  at.depth -= back;
  Floats radius = min(max(wide / at.texel, all(kLeast)), all(kMost));
  float search = 0;
  if (map.space.size > 0) search = map.space.point || map.space.size * kReach > kMost ? kMost : map.space.size * kReach;
  search = search > kLeast ? search : kLeast;
  if (!any_near(map, at, max(radius, all(search)))) return all(1.0f);
  const Floats limit = at.texel * 0.25f - at.depth;
  if (map.space.size > 0) radius = min(max(radius, edge_radius(map, at, limit, search)), all(kMost));
  Ints dark{};
  const auto test = [&](int k) __attribute__((always_inline)) {
    dark -= (Ints)(nearness_at(map, at, radius * map.taps->x[k], radius * map.taps->y[k]) > limit);
  };
  for (int k = 0; k < DepthTaps::kFirst; ++k) test(k);
  const Ints some = dark;
  const Mask mixed = at.known & (some > 0) & (some < DepthTaps::kFirst);
  const Floats same = only(some == 0, all(1.0f));
  if (!any(mixed)) return select(at.known, same, all(1.0f));
  for (int k = DepthTaps::kFirst; k < DepthTaps::kAll; ++k) test(k);
  const Floats part = 1.0f - to_floats(dark) * (1.0f / DepthTaps::kAll);
  return select(at.known, select(mixed, part, same), all(1.0f));
}

/// Returns the part of a sun's light that is lost on its last sky.reach metres. `back` as in light_past().
__attribute__((noinline)) inline Floats lost_nearby(const image::SkyDepths& sky, const image::DepthView& map,
                                                    Floats3 place, Floats back) {
  using image::DepthTaps;
  constexpr float kWide = 0.2f,
                  kMost = image::kDepthMargin;  // of a filter: its radius in reaches; greatest one, texels
  Floats3 offset = place - all3(map.space.origin);
  const Mask sane = finite(offset);
  offset = only(sane, offset);
  const InDepthMap at = in_sun_map(map.space, offset, sane);
  const Floats radius = min(kWide * sky.reach / at.texel, all(kMost));
  if (!any_near(map, at, radius)) return Floats{};
  const Floats depth = at.depth - back, limit = at.texel * 0.25f - depth;
  Floats lost{};
  for (int k = 0; k < DepthTaps::kFirst; ++k) {
    const Floats here = nearness_at(map, at, radius * map.taps->x[k], radius * map.taps->y[k]);
    const Floats near = 1.0f - max(depth + here, Floats{}) * (1 / sky.reach);
    lost += only(here > limit, max(near, Floats{}));
  }
  return only(at.known, lost * (1.0f / DepthTaps::kFirst));
}

/// Returns the part of the sky's light that arrives. `weight(cosine)`: of light from a direction at an angle to the
/// normal.
template <class Weight>
MOTES_INLINE Floats sky_past(const image::SkyDepths& sky, Floats3 place, Floats3 normal, Floats back,
                             const Weight& weight) {
  Floats lost{}, all_weights = all(1e-3f);
  for (int k = 0; k < image::SkyDepths::kMaps; ++k) {
    const Floats here = weight(dot(normal, all3(sky.toward[k])));
    all_weights += here;
    if (sky.map[k].texels != nullptr) lost += here * lost_nearby(sky, sky.map[k], place, back);
  }
  return 1.0f - sky.part * (lost / all_weights);
}

}  // namespace motes::MOTES_ISA
