// Finds the surfaces that rays meet, and the light that they send to the eye.
#include "image/raycast/cast.h"

#include "image/daylight_parts.h"
#include "image/grid.h"
#include "image/light/depth_sight.h"
#include "image/light/lamp_lanes.h"
#include "image/light/particle_lanes.h"
#include "image/light/shadow_lanes.h"
#include "image/light/sky_lanes.h"
#include "image/project/screen_lanes.h"
#include "image/raycast/cast_solids.h"
#include "image/raycast/cast_textures.h"
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

// Light on a surface that faces its source.
constexpr auto kSky = static_cast<float>(image::kSky);
constexpr auto kBounce = static_cast<float>(image::kBounce), kTint = static_cast<float>(image::kTint);

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

// Returns which rays meet an object before they reach a light. Shapes cast no shadow on themselves: their outer
// surfaces are convex, so a point facing the light is lit. (From inside, a box is a room without a ceiling, and a pipe
// lets light in.)
Mask in_shadow(const CastSolid* solids, std::size_t count, const Rays& rays, Floats far, Ints object, Mask open) {
  Mask dark{};
  for (const CastSolid* solid = solids; solid != solids + count; ++solid) {
    Mask here = open & ~dark;
    if (solid->nodes == nullptr) here &= object != static_cast<std::int32_t>(solid->number);
    if (!any(here)) continue;
    dark |= here & blocked(*solid, rays, Floats{}, far, here);
  }
  return dark;
}

// Returns the part of a light with a size that is visible from surfaces. `rays_to(k)` returns the rays to its k-th
// sample point. If the first kFirst points agree, the others are not tested.
template <class RaysTo>
MOTES_INLINE Floats part_in_sight(const CastSolid* solids, std::size_t count, Floats far, Ints object, Mask open,
                                  const RaysTo& rays_to) {
  constexpr int kFirst = image::LightPlaces::kFirst, kAll = image::LightPlaces::kAll;
  if (count == 0) return all(1.0f);
  Ints dark{};
  for (int k = 0; k < kFirst; ++k) dark -= in_shadow(solids, count, rays_to(k), far, object, open);
  const Mask mixed = open & (dark > 0) & (dark < kFirst);
  if (!any(mixed)) return only(dark == 0, all(1.0f));
  for (int k = kFirst; k < kAll; ++k) dark -= in_shadow(solids, count, rays_to(k), far, object, mixed);
  return select(mixed, 1.0f - to_floats(dark) * (1.0f / kAll), only(dark == 0, all(1.0f)));
}

// Loads the materials of objects, one per lane; mostly they are all the same.
MOTES_INLINE void load_materials(const image::Material* materials, Ints object, Mask seen, Floats3& color,
                                 Floats& emitted) {
  std::size_t first = 0;
  while (first + 1 < kLanes && seen[first] == 0) ++first;
  const Ints one = Ints{} + object[first];
  if (!any(seen & (object != one))) {
    const image::Material& material = materials[object[first]];
    color = all3(material.color);
    emitted = all(material.emitted);
    return;
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const image::Material& material = materials[seen[i] != 0 ? object[i] : object[first]];
    color.x[i] = material.color[0];
    color.y[i] = material.color[1];
    color.z[i] = material.color[2];
    emitted[i] = material.emitted;
  }
}

// Visible surfaces, and the light found on them so far.
struct Shading {
  Floats3 point, normal;
  Floats offset;  // distance from the surface at which rays to lights start, so that they do not meet it
  Ints object;
  Mask seen;
  Floats3 arriving;
  Ints shadows;
};

MOTES_INLINE bool has_size(const image::ShadeView& view) {
  return view.sun_right[0] != 0 || view.sun_right[1] != 0 || view.sun_right[2] != 0;
}

MOTES_INLINE Floats sun_in_sight(const image::ShadeView& view, Floats3 from, const Shading& at, Mask open) {
  return part_in_sight(view.cast.solids, view.cast.count, all(__FLT_MAX__), at.object, open, [&](int k) {
    return Rays{
        from, all3(view.sun.toward) + all3(view.sun_right) * view.places->x[k] + all3(view.sun_up) * view.places->y[k]};
  });
}

// Returns the part of a light that particles let through to surfaces.
MOTES_INLINE Floats light_left(const image::ShadowMap& map, Floats3 point) {
  Floats left = all(1.0f);
  if (map.left != nullptr) left = light_through(map, point, Floats{});
  if (map.sharp.texels != nullptr) left *= light_past(map.sharp, point, Floats{}, Floats{});
  return left;
}

MOTES_INLINE void add_sun(const image::ShadeView& view, Shading& at) {
  const Floats3 sun = all3(view.sun.toward);
  const Floats facing = dot(at.normal, sun);
  const Mask open = at.seen & (facing > 0.0f);
  if (!any(open)) return;
  const Rays rays{at.point + at.normal * at.offset, sun};
  Mask dark{};
  Floats light{};
  if (has_size(view)) {
    const Floats part = sun_in_sight(view, rays.from, at, open);
    dark = open & (part < 0.5f);
    light = only(open, facing * part);
  } else {
    dark = in_shadow(view.cast.solids, view.cast.count, rays, all(__FLT_MAX__), at.object, open);
    light = only(open & ~dark, facing);
  }
  light *= light_left(view.sun_shadow, at.point);
  at.arriving = at.arriving + all3(view.sun.color) * light;
  at.shadows |= dark & 1;
}

// Returns the part of a lamp that is visible from a surface. The lamp is a disc that faces the surface.
MOTES_INLINE Floats part_of_lamp(const image::CastLight& light, const image::LightPlaces& places, Floats3 from,
                                 const Shading& at, Mask open) {
  const Floats3 way = all3(light.position) - from;
  const Mask upright = abs(way.y) * abs(way.y) > dot(way, way) * 0.8f;
  const Floats3 axis{only(upright, all(1.0f)), only(~upright, all(1.0f)), Floats{}};
  const Floats3 across = unit(cross(way, axis)), upward = unit(cross(across, way));
  return part_in_sight(light.solids, light.count, all(1), at.object, open, [&](int k) {
    return Rays{from, way + across * (places.x[k] * light.radius) + upward * (places.y[k] * light.radius)};
  });
}

MOTES_INLINE void add_light(const image::CastLight& light, const image::LightPlaces& places, Ints bit, Shading& at) {
  const Floats3 position = all3(light.position);
  const Floats3 along = position - at.point;
  const Floats facing = dot(at.normal, along);
  const Mask open = at.seen & (facing > 0.0f);
  if (!any(open)) return;
  const Floats3 from = at.point + at.normal * at.offset;
  const Floats square = max(dot(along, along), all(1e-6f));
  Mask dark;
  Floats part;
  if (light.radius > 0) {
    const Floats seen = part_of_lamp(light, places, from, at, open);
    dark = open & (seen < 0.5f);
    part = only(open, seen * facing / (square * sqrt(square)));
  } else {
    dark = in_shadow(light.solids, light.count, {from, position - from}, all(1), at.object, open);
    part = only(open & ~dark, facing / (square * sqrt(square)));
  }
  if (light.per_cosine > 0) part *= in_cone(light, along, square);
  part *= light_left(light.shadow, at.point);
  at.arriving = at.arriving + all3(light.color) * part;
  at.shadows |= dark & bit;
}

MOTES_INLINE Floats3 ambient_light(const image::ShadeView& view, Floats3 normal) {
  if (view.sky.kind == image::Sky::Kind::none) {
    const Floats3 background = all3(view.sky.color);
    const Floats up = 0.5f + 0.5f * normal.y;
    return {kBounce + (kSky - kBounce + kTint * background.x) * up,
            kBounce + (kSky - kBounce + kTint * background.y) * up,
            kBounce + (kSky - kBounce + kTint * background.z) * up};
  }
  return ambient_at(view.ambient, normal);
}

// Returns the part of the sky's light that nothing nearby keeps from surfaces.
__attribute__((noinline)) Floats sky_in_sight(const image::ShadeView& view, const Shading& at) {
  const Mask upright = abs(at.normal.y) > 0.9f;
  const Floats3 axis{only(upright, all(1.0f)), only(~upright, all(1.0f)), Floats{}};
  const Floats3 across = unit(cross(at.normal, axis)), upward = cross(across, at.normal);
  const Floats part = part_in_sight(view.around, view.around_count, all(1), at.object, at.seen, [&](int k) {
    const float x = view.places->x[k], y = view.places->y[k], rest = 1 - x * x - y * y;
    const Floats3 way = across * x + upward * y + at.normal * __builtin_sqrtf(rest > 0.01f ? rest : 0.01f);
    return Rays{at.point + at.normal * at.offset, way * view.occlusion_reach};
  });
  const Floats left = 1.0f - view.occlusion * (1.0f - part);
  return left *
         sky_past(view.sky_depths, at.point, at.normal, Floats{}, [](Floats cosine) { return max(cosine, Floats{}); });
}

// Multiplies colours by those of the objects' images.
__attribute__((noinline)) void add_images(const image::ShadeView& view, const Shading& at, const Ints* triangle,
                                          Floats distance, Floats3 along, Floats3& color) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (at.seen[lane] == 0) continue;
    const image::Material& material = view.materials[at.object[lane]];
    if (material.image == nullptr) continue;
    Float3 place{at.point.x[lane] + view.eye[0], at.point.y[lane] + view.eye[1], at.point.z[lane] + view.eye[2]};
    Float3 normal{at.normal.x[lane], at.normal.y[lane], at.normal.z[lane]};
    const Float3 way{along.x[lane], along.y[lane], along.z[lane]};
    const float straight = __builtin_fabsf(dot(normal, way)) / __builtin_sqrtf(dot(way, way));
    const float footprint = distance[lane] * view.cast.pixel / (straight > 0.05f ? straight : 0.05f);
    if (material.mesh != nullptr) {
      place = lane_of(into_mesh(*material.mesh, at.point) + all3(material.mesh->value), lane);
      normal = lane_of(into_mesh(*material.mesh, at.normal), lane);
    }
    Float3 light;
    if (material.uv != nullptr) {
      const auto number = static_cast<std::size_t>((*triangle)[lane]);
      light = image_on_mesh(material, number, parts_of(material.mesh->triangles[number], place), footprint);
    } else {
      light = image_light(material, place, normal, footprint);
    }
    set_lane(color, lane, {color.x[lane] * light.x, color.y[lane] * light.y, color.z[lane] * light.z});
  }
}

// Multiplies colours by those of meshes, interpolated linearly between the corners of the visible triangle.
__attribute__((noinline)) void add_mesh_colors(const image::ShadeView& view, const Shading& at, Ints triangle,
                                               Floats3& color) {
  Floats3 place{}, normal{}, corner[3]{}, tint[3]{};
  Mask tinted{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (at.seen[lane] == 0) continue;
    const image::Material& material = view.materials[at.object[lane]];
    if (material.colors == nullptr) continue;
    tinted[lane] = -1;
    const Floats3 here = into_mesh(*material.mesh, at.point) + all3(material.mesh->value);
    set_lane(place, lane, {here.x[lane], here.y[lane], here.z[lane]});
    const auto number = static_cast<std::size_t>(triangle[lane]);
    const meshes::BvhTriangle& seen = material.mesh->triangles[number];
    set_lane(normal, lane, {seen.normal[0], seen.normal[1], seen.normal[2]});
    for (int k = 0; k < 3; ++k) {
      const float* own = material.colors + 9 * number + static_cast<std::size_t>(3 * k);
      set_lane(corner[k], lane, {seen.corner[k][0], seen.corner[k][1], seen.corner[k][2]});
      set_lane(tint[k], lane, {own[0], own[1], own[2]});
    }
  }
  if (!any(tinted)) return;
  Floats part[3], all_parts{};
  for (int k = 0; k < 3; ++k) {
    const Floats3 one = corner[(k + 1) % 3] - place, other = corner[(k + 2) % 3] - place;
    part[k] = max(dot(normal, cross(one, other)), Floats{});
    all_parts += part[k];
  }
  const Floats per = 1.0f / max(all_parts, all(1e-37f));
  const Floats3 mixed = (tint[0] * part[0] + tint[1] * part[1] + tint[2] * part[2]) * per;
  color = select(tinted, Floats3{color.x * mixed.x, color.y * mixed.y, color.z * mixed.z}, color);
}

// Replaces the normals of meshes that have normals at their corners.
__attribute__((noinline)) void smooth_normals(const image::ShadeView& view, Ints triangle, Shading& at) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (at.seen[lane] == 0) continue;
    const image::Material& material = view.materials[at.object[lane]];
    if (material.normals == nullptr) continue;
    const auto number = static_cast<std::size_t>(triangle[lane]);
    const Float3 place = lane_of(into_mesh(*material.mesh, at.point) + all3(material.mesh->value), lane);
    const Float3 parts = parts_of(material.mesh->triangles[number], place);
    const Float3 own{mixed(material.normals, number, 3, 0, parts), mixed(material.normals, number, 3, 1, parts),
                     mixed(material.normals, number, 3, 2, parts)};
    const float square = dot(own, own);
    if (!(square > 1e-12f)) continue;
    Float3 normal = lane_of(out_of_mesh(*material.mesh, all3(own)) * all(1 / __builtin_sqrtf(square)), lane);
    const Float3 flat = lane_of(at.normal, lane);
    if (dot(normal, flat) < 0) normal = times(normal, -1);
    set_lane(at.normal, lane, normal);
  }
}

// Applies the view's fog to light; without fog, fades distant objects into the sky.
MOTES_INLINE Floats3 through_air(const image::ShadeView& view, Floats3 light, Floats distance, Floats3 along,
                                 Floats3 background) {
  const Floats square = min(distance * distance * dot(along, along), all(1e37f));  // infinite on a horizon
  if (view.fog_density > 0) {
    const Floats clear = exp(-min(sqrt(square) * view.fog_density, all(80.0f)));
    return light * clear + all3(view.fog) * (1.0f - clear);
  }
  const Floats fog = square / (square + view.fog_square);
  const Floats clear = 1.0f - fog;
  return {light.x * clear + background.x * fog, light.y * clear + background.y * fog,
          light.z * clear + background.z * fog};
}

void shade(const image::ShadeView& view, const float* x, const float* y, std::size_t count, const image::Surfaces& from,
           const image::Shades& to) {
  const bool plain = view.sky.kind == image::Sky::Kind::none;
  Floats3 background = all3(view.sky.color);
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Ints surface = load_ints(from.surface + i);
    Shading at{};
    at.seen = (surface != 0) & first_lanes(count - i);
    if (!plain) background = sky_light(view.sky, directions(view.cast, x + i, y + i), first_lanes(count - i));
    if (!any(at.seen)) {
      store3(to.light, i, background);
      store_uints(to.shadows + i, Uints{});
      continue;
    }
    const Floats3 along = directions(view.cast, x + i, y + i);
    const Floats distance = only(at.seen, load(from.distance + i));
    at.point = along * distance;
    at.normal = load3(from.normal, i);
    at.offset = distance * 2e-5f + view.grain;
    at.object = (Ints)(((Uints)surface - 1u) >> 2);
    if (view.cast.colored) smooth_normals(view, load_ints(from.triangle + i), at);
    at.arriving = ambient_light(view, at.normal);
    if (view.occlusion > 0) at.arriving = at.arriving * sky_in_sight(view, at);
    if (view.sun.shines) add_sun(view, at);
    for (std::size_t light = 0; light < view.light_count; ++light) {
      add_light(view.lights[light], *view.places, Ints{} + (2 << (light % 30)), at);
    }
    Floats3 color;
    Floats emitted;
    load_materials(view.materials, at.object, at.seen, color, emitted);
    Ints triangle{};
    if (view.cast.colored) triangle = load_ints(from.triangle + i);
    if (view.has_images) add_images(view, at, &triangle, distance, along, color);
    if (view.cast.colored) add_mesh_colors(view, at, triangle, color);
    const Floats3 shown{color.x * (at.arriving.x + emitted), color.y * (at.arriving.y + emitted),
                        color.z * (at.arriving.z + emitted)};
    const Floats3 light = through_air(view, shown, distance, along, background);
    store3(to.light, i, select(at.seen, light, background));
    store_uints(to.shadows + i, (Uints)at.shadows);
  }
}

// Rays start at the lit side of a particle, so a particle that rests on a solid is not shaded by it.
void in_sight(const image::ShadeView& view, const image::ShadedParticles& particles, std::size_t first,
              std::size_t last, float* to, std::size_t stride) {
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
    store(here, sized_sun ? sun_in_sight(view, at.point + sun * at.offset, at, open) : all(1.0f));
    for (std::size_t k = 0; k < view.light_count; ++k) {
      const image::CastLight& light = view.lights[k];
      const Floats3 from = at.point + unit(all3(light.position) - at.point) * at.offset;
      const bool sized = light.radius > 0;
      store(here + (k + 1) * stride, sized ? part_of_lamp(light, *view.places, from, at, open) : all(1.0f));
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
