// The light that surfaces of solids send towards a ray's start. Compiled once for each instruction set.
#pragma once

#include "image/daylight_parts.h"
#include "image/light/depth_sight.h"
#include "image/light/finish_lanes.h"
#include "image/light/lamp_lanes.h"
#include "image/light/shadow_lanes.h"
#include "image/raycast/cast_solids.h"
#include "image/raycast/cast_textures.h"

namespace motes::MOTES_ISA {

// Light on a surface that faces its source.
inline constexpr auto kSky = static_cast<float>(image::kSky);
inline constexpr auto kBounce = static_cast<float>(image::kBounce), kTint = static_cast<float>(image::kTint);

/// Returns which rays meet an object before they reach a light. Shapes cast no shadow on themselves: their outer
/// surfaces are convex, so a point facing the light is lit. (From inside, a box is a room without a ceiling, and a pipe
/// lets light in.) `masks` says which rays each object may meet; null: all.
MOTES_OUTLINE Mask in_shadow(const image::CastSolid* solids, std::size_t count, const Rays& rays, Floats far,
                             Ints object, Mask open, const std::uint32_t* masks = nullptr) {
  Mask dark{};
  for (const image::CastSolid* solid = solids; solid != solids + count; ++solid) {
    Mask here = open & ~dark;
    if (solid->nodes == nullptr) here &= object != static_cast<std::int32_t>(solid->number);
    if (masks != nullptr) here &= (Mask)load_uints(masks + static_cast<std::size_t>(solid - solids) * kLanes);
    if (!any(here)) continue;
    dark |= here & blocked(*solid, rays, Floats{}, far, here);
  }
  return dark;
}

/// Returns the part of a light with a size that is visible from surfaces. `rays_to(k)` returns the rays to its k-th
/// sample point. If the first kFirst points agree, the others are not tested. `masks`: see in_shadow().
template <class RaysTo>
MOTES_INLINE Floats part_in_sight(const image::CastSolid* solids, std::size_t count, Floats far, Ints object, Mask open,
                                  const RaysTo& rays_to, const std::uint32_t* masks = nullptr) {
  constexpr int kFirst = image::LightPlaces::kFirst, kAll = image::LightPlaces::kAll;
  if (count == 0) return all(1.0f);
  Ints dark{};
  for (int k = 0; k < kFirst; ++k) dark -= in_shadow(solids, count, rays_to(k), far, object, open, masks);
  const Mask mixed = open & (dark > 0) & (dark < kFirst);
  if (!any(mixed)) return only(dark == 0, all(1.0f));
  for (int k = kFirst; k < kAll; ++k) dark -= in_shadow(solids, count, rays_to(k), far, object, mixed, masks);
  return select(mixed, 1.0f - to_floats(dark) * (1.0f / kAll), only(dark == 0, all(1.0f)));
}

/// The objects that may stand before a light, and which rays each may meet; null: all.
struct Casters {
  const image::CastSolid* solids;
  std::size_t count;
  const std::uint32_t* masks = nullptr;
};

/// Selects the objects whose balls touch the cones that begin at `from`, along unit vectors `way` of length `far`. A
/// cone is `wide` metres thick at its start, and grows by `per_metre`. A ray is only tested against what its own cone
/// touches, so that what it finds does not depend on the rays beside it.
MOTES_OUTLINE Casters near_cones(Casters all_of_them, Floats3 from, Floats3 way, Floats far, float wide,
                                 float per_metre, Mask open, const image::NearSolids& near) {
  constexpr float kSpare = 1e-4f;  // far more than rounding
  std::size_t count = 0;
  for (const image::CastSolid* solid = all_of_them.solids; solid != all_of_them.solids + all_of_them.count; ++solid) {
    const Floats3 offset = all3(solid->center) - from;
    const Floats along = min(max(dot(offset, way), Floats{}), far);
    const Floats3 aside = offset - way * along;
    const Floats room = (solid->radius + wide + per_metre * (along + solid->radius)) * (1.0f + kSpare) +
                        (along + sqrt(dot(from, from))) * kSpare;
    const Mask may = open & ~(dot(aside, aside) > room * room);  // also if the ball is infinite
    if (!any(may)) continue;
    near.solids[count] = *solid;
    store_uints(near.masks + count * kLanes, (Uints)may);
    ++count;
  }
  return {near.solids, count, near.masks};
}

/// Loads the materials of objects, one per lane; mostly they are all the same.
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

/// Visible surfaces, and the light found on them so far.
struct Shading {
  Floats3 point, normal;
  Floats offset;  // distance from the surface at which rays to lights start, so that they do not meet it
  Ints object;
  Mask seen;
  Floats3 arriving;
  Ints shadows;
  Gleam* gleam;  // what they reflect; null: nothing
};

MOTES_INLINE bool has_size(const image::ShadeView& view) {
  return view.sun_right[0] != 0 || view.sun_right[1] != 0 || view.sun_right[2] != 0;
}

MOTES_INLINE Floats sun_in_sight(const image::ShadeView& view, Floats3 from, const Shading& at, Mask open,
                                 Casters casters) {
  return part_in_sight(
      casters.solids, casters.count, all(__FLT_MAX__), at.object, open,
      [&](int k) {
        return Rays{from, all3(view.sun.toward) + all3(view.sun_right) * view.places->x[k] +
                              all3(view.sun_up) * view.places->y[k]};
      },
      casters.masks);
}

/// Returns the part of a light that particles let through to surfaces.
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
    const Floats part = sun_in_sight(view, rays.from, at, open, {view.cast.solids, view.cast.count});
    dark = open & (part < 0.5f);
    light = only(open, facing * part);
  } else {
    dark = in_shadow(view.cast.solids, view.cast.count, rays, all(__FLT_MAX__), at.object, open);
    light = only(open & ~dark, facing);
  }
  light *= light_left(view.sun_shadow, at.point);
  const Floats3 more = all3(view.sun.color) * light;
  at.arriving = at.arriving + more;
  if (at.gleam != nullptr) at.gleam->add(more, sun);
  at.shadows |= dark & 1;
}

/// Returns the part of a lamp that is visible from a surface. The lamp is a disc that faces the surface.
MOTES_INLINE Floats part_of_lamp(const image::CastLight& light, const image::LightPlaces& places, Floats3 from,
                                 const Shading& at, Mask open, Casters casters) {
  const Floats3 way = all3(light.position) - from;
  const Mask upright = abs(way.y) * abs(way.y) > dot(way, way) * 0.8f;
  const Floats3 axis{only(upright, all(1.0f)), only(~upright, all(1.0f)), Floats{}};
  const Floats3 across = unit(cross(way, axis)), upward = unit(cross(across, way));
  return part_in_sight(
      casters.solids, casters.count, all(1), at.object, open,
      [&](int k) {
        return Rays{from, way + across * (places.x[k] * light.radius) + upward * (places.y[k] * light.radius)};
      },
      casters.masks);
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
    const Floats seen = part_of_lamp(light, places, from, at, open, {light.solids, light.count});
    dark = open & (seen < 0.5f);
    part = only(open, seen * facing / (square * sqrt(square)));
  } else {
    dark = in_shadow(light.solids, light.count, {from, position - from}, all(1), at.object, open);
    part = only(open & ~dark, facing / (square * sqrt(square)));
  }
  if (light.per_cosine > 0) part *= in_cone(light, along, square);
  part *= light_left(light.shadow, at.point);
  const Floats3 more = all3(light.color) * part;
  at.arriving = at.arriving + more;
  if (at.gleam != nullptr) at.gleam->add(more, along);
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

/// Returns the part of the sky's light that nothing nearby keeps from surfaces.
MOTES_OUTLINE Floats sky_in_sight(const image::ShadeView& view, const Shading& at) {
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

/// The rays that met surfaces.
struct Sight {
  Floats3 along;    // their directions
  Floats distance;  // to the surfaces, in units of `along`
  Ints triangle;    // of a mesh
};

/// Returns the light of a picture of a material, at the surface of one lane.
MOTES_OUTLINE Float3 picture_at(const image::ShadeView& view, const Shading& at, const Sight& sight, std::size_t lane,
                                const image::Material& material, const image::Texture& picture) {
  Float3 place{at.point.x[lane] + view.eye[0], at.point.y[lane] + view.eye[1], at.point.z[lane] + view.eye[2]};
  Float3 normal = lane_of(at.normal, lane);
  const Float3 way = lane_of(sight.along, lane);
  const float straight = __builtin_fabsf(dot(normal, way)) / __builtin_sqrtf(dot(way, way));
  const float footprint = sight.distance[lane] * view.cast.pixel / (straight > 0.05f ? straight : 0.05f);
  if (material.mesh != nullptr) {
    place = lane_of(into_mesh(*material.mesh, at.point) + all3(material.mesh->value), lane);
    normal = lane_of(into_mesh(*material.mesh, at.normal), lane);
  }
  if (material.uv == nullptr) return image_light(material, picture, place, normal, footprint);
  const auto number = static_cast<std::size_t>(sight.triangle[lane]);
  return image_on_mesh(material, picture, number, parts_of(material.mesh->triangles[number], place), footprint);
}

/// Multiplies colours by those of the objects' images.
MOTES_OUTLINE void add_images(const image::ShadeView& view, const Shading& at, const Sight& sight, Floats3& color) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (at.seen[lane] == 0) continue;
    const image::Material& material = view.materials[at.object[lane]];
    if (material.image == nullptr) continue;
    const Float3 light = picture_at(view, at, sight, lane, material, *material.image);
    set_lane(color, lane, {color.x[lane] * light.x, color.y[lane] * light.y, color.z[lane] * light.z});
  }
}

/// Loads the finishes of objects, one per lane; returns whether any of them reflects.
MOTES_OUTLINE bool load_finishes(const image::ShadeView& view, const Shading& at, const Sight& sight,
                                 FinishLanes& finish) {
  bool reflects = false;
  finish = {all(1.0f), Floats{}};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (at.seen[lane] == 0) continue;
    const image::Material& material = view.materials[at.object[lane]];
    if (!material.finish.reflects()) continue;
    reflects = true;
    finish.roughness[lane] = material.finish.roughness;
    finish.metal[lane] = material.finish.metal;
    if (material.finish_image == nullptr) continue;
    const Float3 part = picture_at(view, at, sight, lane, material, *material.finish_image);
    finish.roughness[lane] *= part.y < 1 ? part.y : 1;
    finish.metal[lane] *= part.z < 1 ? part.z : 1;
  }
  return reflects;
}

/// Multiplies colours by those of meshes, interpolated linearly between the corners of the visible triangle.
MOTES_OUTLINE void add_mesh_colors(const image::ShadeView& view, const Shading& at, Ints triangle, Floats3& color) {
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

/// Replaces the normals of meshes that have normals at their corners.
MOTES_OUTLINE void smooth_normals(const image::ShadeView& view, Ints triangle, Shading& at) {
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

/// Finds the light on surfaces: of the sky, the sun and the lamps.
MOTES_OUTLINE void add_lights(const image::ShadeView& view, Shading& at) {
  at.arriving = ambient_light(view, at.normal);
  if (view.occlusion > 0) at.arriving = at.arriving * sky_in_sight(view, at);
  if (view.sun.shines) add_sun(view, at);
  for (std::size_t light = 0; light < view.light_count; ++light) {
    add_light(view.lights[light], *view.places, Ints{} + (2 << (light % 30)), at);
  }
}

/// Returns the light that surfaces send towards the start of their rays.
MOTES_OUTLINE Floats3 light_sent(const image::ShadeView& view, const Sight& sight, Shading& at) {
  if (view.cast.colored) smooth_normals(view, sight.triangle, at);
  FinishLanes finish;
  const bool reflects = view.reflects && load_finishes(view, at, sight, finish);
  Floats3 color;
  Floats emitted;
  load_materials(view.materials, at.object, at.seen, color, emitted);
  if (view.has_images) add_images(view, at, sight, color);
  if (view.cast.colored) add_mesh_colors(view, at, sight.triangle, color);
  if (!reflects) {
    add_lights(view, at);
    return {color.x * (at.arriving.x + emitted), color.y * (at.arriving.y + emitted),
            color.z * (at.arriving.z + emitted)};
  }
  Gleam gleam(finish, at.normal, unit(-sight.along));
  at.gleam = &gleam;
  add_lights(view, at);
  gleam.add_sky(view.sky, view.ambient, at.seen);
  SentLight sent = gleam.sent(at.arriving);
  sent.on_color = sent.on_color + Floats3{emitted, emitted, emitted};  // in the order that other surfaces have
  return of_color(sent, color);
}

/// Applies the view's fog to light; without fog, fades distant objects into the sky.
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

}  // namespace motes::MOTES_ISA
