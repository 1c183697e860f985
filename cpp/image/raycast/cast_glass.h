// Glass: what is seen through it, and what it reflects. Compiled once for each instruction set.
//
// Rays are followed from surface to surface until they meet something opaque or the sky. Inside a solid of glass only
// its own surface counts, so glass within it is not seen.
#pragma once

#include "image/raycast/cast_light.h"

namespace motes::MOTES_ISA {

/// Crossings of a vector of rays with the first of several solids.
struct FirstHit {
  Floats distance;
  Floats3 normal;  // unit vector towards the rays' starts
  Ints object, surface, triangle;  // `surface`: as in image::Surfaces
  Mask met;
};

/// Finds the first crossings before `to.distance`. `open(solid)`: the rays that may meet a solid.
template <bool kFromEye, class Open>
MOTES_INLINE void find_first(const image::CastSolid* solids, std::size_t count, const Rays& rays, Floats near,
                             const Open& open, FirstHit& to) {
  for (const image::CastSolid* solid = solids; solid != solids + count; ++solid) {
    const Mask may = open(*solid);
    if (!any(may)) continue;
    const RayHit crossing = find<kFromEye>(*solid, rays, near, to.distance);
    const Mask met = crossing.met & may;
    if (!any(met)) continue;
    const auto number = static_cast<std::int32_t>(solid->number);
    to.distance = select(met, crossing.distance, to.distance);
    to.normal = select(met, unit(towards(normals(*solid, rays, crossing), rays)), to.normal);
    to.object = select(met, all_ints(number), to.object);
    to.surface = select(met, (solid->nodes == nullptr ? crossing.face : Ints{}) + (1 + 4 * number), to.surface);
    to.triangle = select(met, crossing.face, to.triangle);
    to.met |= met;
  }
}

/// Rays on their way through glass.
struct GlassRays {
  Rays rays;     // `along`: unit vectors
  Floats index;  // of refraction, of the glass that they met last
  Ints object;   // that glass
  Mask inside;   // it
  Floats3 before_from, before_along;  // where and how they met it
};

/// Returns the part of light that a surface of glass reflects (Schlick). `cosine`: of the angle of incidence.
MOTES_INLINE Floats reflected_part(Floats index, Floats cosine) {
  const Floats ratio = (index - 1.0f) / (index + 1.0f), least = ratio * ratio;
  const Floats rest = 1.0f - min(max(cosine, Floats{}), all(1.0f)), square = rest * rest;
  return least + (1.0f - least) * (square * square * rest);
}

/// Refracts rays at surfaces, or reflects them where the angle inside is too flat. `offset`: from the surface at which
/// they go on, m.
MOTES_INLINE void cross_surface(const FirstHit& hit, Floats offset, Mask met, GlassRays& r) {
  const Floats3 point = at(r.rays, hit.distance);
  const Floats bend = select(r.inside, r.index, 1.0f / r.index);
  const Floats cosine = -dot(r.rays.along, hit.normal);
  const Floats square = 1.0f - bend * bend * (1.0f - cosine * cosine);
  const Mask passes = square >= 0.0f;
  const Floats3 through = r.rays.along * bend + hit.normal * (bend * cosine - sqrt(max(square, Floats{})));
  const Floats3 back = r.rays.along + hit.normal * (2.0f * cosine);
  const Mask enters = met & ~r.inside;
  r.before_from = select(enters, point - hit.normal * offset, r.before_from);
  r.before_along = select(enters, r.rays.along, r.before_along);
  r.rays.along = select(met, unit(select(passes, through, back)), r.rays.along);
  r.rays.from = select(met, point + hit.normal * select(passes, -offset, offset), r.rays.from);
  r.inside = (met & passes & ~r.inside) | (~(met & passes) & r.inside);
}

/// Sets the numbers of glass: its index of refraction, and whether it has an inside.
MOTES_INLINE void load_glass(const image::ShadeView& view, Ints object, Mask lanes, Floats& index) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] != 0) index[lane] = view.materials[object[lane]].glass;
  }
}

/// Returns the planes among the objects of some rays: what is below a plane needs no other side.
MOTES_INLINE Mask in_planes(const image::ShadeView& view, Ints object) {
  Mask found{};
  for (const image::CastSolid* solid = view.glass; solid != view.glass + view.glass_count; ++solid) {
    const bool plane = solid->nodes == nullptr && solid->kind == shapes::Kind::plane;
    if (plane) found |= object == static_cast<std::int32_t>(solid->number);
  }
  return found;
}

/// Returns the smooth normal of glass, if it is a mesh that has normals.
MOTES_INLINE void smooth_glass(const image::ShadeView& view, const Rays& rays, FirstHit& hit) {
  if (!view.cast.colored) return;
  Shading surface{};
  surface.point = at(rays, hit.distance);
  surface.normal = hit.normal;
  surface.object = hit.object;
  surface.seen = hit.met;
  smooth_normals(view, hit.triangle, surface);
  // Normals of corners may lean away from the ray.
  hit.normal = select(dot(surface.normal, rays.along) < 0.0f, surface.normal, hit.normal);
}

MOTES_INLINE Ints mixed_marks(Ints marks, Ints more) { return (Ints)((Uints)marks * 31u + (Uints)more); }

/// Returns the light that rays find behind the glass that they have met, from the eye. `marks`: changes with what they
/// find.
MOTES_OUTLINE Floats3 light_behind(const image::ShadeView& view, GlassRays& r, Floats offset, Floats3 background,
                                   Mask open, Ints& marks) {
  constexpr int kMostSurfaces = 6;
  FirstHit found{};
  const Mask there = open;
  Ints surfaces = all_ints(1);  // met so far: counted per ray, as what a ray sees must not depend on its neighbours
  while (any(open)) {
    FirstHit glass{all(__FLT_MAX__), {}, {}, {}, {}, {}};
    const Mask goes_on = open & (surfaces < kMostSurfaces);
    if (any(goes_on)) {
      find_first<false>(
          view.glass, view.glass_count, r.rays, Floats{},
          [&](const image::CastSolid& solid) {
            return goes_on & (~r.inside | (r.object == static_cast<std::int32_t>(solid.number)));
          },
          glass);
      const Mask thin = goes_on & r.inside & ~glass.met & ~in_planes(view, r.object);  // without another side
      r.rays.from = select(thin, r.before_from, r.rays.from);
      r.rays.along = select(thin, r.before_along, r.rays.along);
      r.inside &= ~thin;
      surfaces -= thin;
      if (any(thin)) continue;
    }
    FirstHit hit = glass;
    hit.met = Mask{};
    find_first<false>(
        view.opaque, view.opaque_count, r.rays, Floats{}, [&](const image::CastSolid&) { return open; }, hit);
    const Mask ends = open & (hit.met | ~glass.met);
    found.met |= ends & hit.met;
    found.normal = select(ends, hit.normal, found.normal);
    found.object = select(ends, hit.object, found.object);
    found.triangle = select(ends, hit.triangle, found.triangle);
    found.distance = select(ends, only(hit.met, hit.distance), found.distance);
    marks = select(open, mixed_marks(marks, hit.surface), marks);
    open &= ~ends;
    if (!any(open)) break;
    marks = select(open, mixed_marks(marks, glass.triangle), marks);
    smooth_glass(view, r.rays, glass);
    load_glass(view, glass.object, open & ~r.inside, r.index);
    r.object = select(open, glass.object, r.object);
    cross_surface(glass, offset, open, r);
    surfaces -= open;
  }
  Floats3 light =
      select(there, view.sky.kind == image::Sky::Kind::none ? background : sky_light(view.sky, r.rays.along, there),
             Floats3{});
  if (!any(found.met)) return light;
  Shading surface{};
  surface.seen = found.met;
  surface.point = at(r.rays, found.distance);
  surface.normal = found.normal;
  surface.object = found.object;
  surface.offset = offset;
  const Floats far = sqrt(dot(surface.point, surface.point));
  const Floats3 shown = light_sent(view, {r.rays.along, far, found.triangle}, surface);
  marks = select(found.met, mixed_marks(marks, surface.shadows), marks);
  return select(found.met, through_air(view, shown, all(1.0f), surface.point, background), light);
}

/// Replaces the light of rays that meet glass before anything else. `sight`: see directions(); `marks`: see
/// Shades::shadows.
MOTES_OUTLINE void add_glass(const image::ShadeView& view, const Sight& sight, Mask open, Floats3 background,
                             Floats3& light, Ints& marks) {
  const Floats3 along = sight.along;
  FirstHit hit{sight.distance, {}, {}, {}, {}, {}};
  const Rays rays{Floats3{}, along};
  find_first<true>(
      view.glass, view.glass_count, rays, all(view.cast.near), [&](const image::CastSolid&) { return open; }, hit);
  if (!any(hit.met)) return;
  smooth_glass(view, rays, hit);
  Shading surface{};
  surface.seen = hit.met;
  surface.point = only(hit.met, at(rays, hit.distance));
  surface.normal = hit.normal;
  surface.object = hit.object;
  surface.offset = hit.distance * 2e-5f + view.grain;
  const Floats3 way = unit(along);
  Gleam gleam({Floats{}, all(1.0f)}, hit.normal, -way);
  surface.gleam = &gleam;
  add_lights(view, surface);
  gleam.add_sky(view.sky, view.ambient, hit.met);
  Floats3 tint{};
  Floats emitted;
  load_materials(view.materials, surface.object, surface.seen, tint, emitted);
  if (view.cast.colored) add_mesh_colors(view, surface, hit.triangle, tint);
  GlassRays through{{Floats3{}, way}, all(1.0f), hit.object, Mask{}, {}, {}};
  load_glass(view, hit.object, hit.met, through.index);
  const Floats mirrors = reflected_part(through.index, -dot(way, hit.normal));
  FirstHit entered = hit;
  entered.distance = only(hit.met, hit.distance * sqrt(dot(along, along)));
  cross_surface(entered, surface.offset, hit.met, through);
  // Facets of one mesh bend rays in different directions, so a crease is an edge of what is seen.
  Ints seen = mixed_marks(hit.surface, hit.triangle);
  const Floats3 behind = light_behind(view, through, surface.offset, background, hit.met, seen);
  const Floats3 reflected = through_air(view, gleam.reflected(), hit.distance, along, background);
  const Floats passes = 1.0f - mirrors;
  const Floats3 all_light =
      reflected * mirrors + Floats3{behind.x * tint.x, behind.y * tint.y, behind.z * tint.z} * passes;
  light = select(hit.met, all_light, light);
  marks = select(hit.met, seen | (Ints{} + static_cast<std::int32_t>(0x80000000u)), marks);
}

}  // namespace motes::MOTES_ISA
