// The light that surfaces of particles send to the eye. Compiled once for each instruction set.
#pragma once

#include "image/light/finish_lanes.h"
#include "image/light/lamp_lanes.h"
#include "image/light/surface_light.h"
#include "simd/elementary.h"

namespace motes::MOTES_ISA {

/// Surfaces of particles in the camera's axes: x to the right, y up, z towards the camera.
struct SurfacePoint {
  Floats3 place;   // m from the eye
  Floats3 normal;  // unit vector to the visible side
};

/// Converts a direction from the camera's axes to the world's.
MOTES_INLINE Floats3 in_world(const image::SurfaceLight& t, Floats3 v) {
  return all3(t.right) * v.x + all3(t.up) * v.y + all3(t.back) * v.z;
}

/// Returns the light on a white surface.
MOTES_INLINE Floats3 light_on(const image::SurfaceLight& t, const SurfacePoint& at) {
  const Floats3 place = in_world(t, at.place), normal = in_world(t, at.normal);
  Floats3 light = ambient_at(t.ambient, normal);
  if (t.sun.shines) light = light + all3(t.sun.color) * max(dot(normal, all3(t.sun.toward)), Floats{});
  for (std::size_t k = 0; k < t.count; ++k) {
    const image::Lamp& lamp = t.lamp[k];
    const Floats3 along = all3(lamp.position) - place;
    const Floats square = max(dot(along, along), all(1e-6f));
    Floats part = max(dot(normal, along), Floats{}) / (square * sqrt(square));
    if (lamp.per_cosine > 0) part *= in_cone(lamp, along, square);
    light = light + all3(lamp.color) * part;
  }
  return light;
}

/// Returns what a surface that reflects sends to the eye: the same as a solid.
MOTES_OUTLINE Sent sent_by(const image::SurfaceLight& t, const SurfacePoint& at) {
  const Floats3 place = in_world(t, at.place), normal = in_world(t, at.normal);
  Gleam gleam(finish_lanes(t.finish), normal, place * (-1.0f / sqrt(max(dot(place, place), all(1e-30f)))));
  Floats3 scattered = ambient_at(t.ambient, normal);
  const auto add = [&](Floats3 light, Floats3 toward) {
    scattered = scattered + light;
    gleam.add(light, toward);
  };
  if (t.sun.shines) add(all3(t.sun.color) * max(dot(normal, all3(t.sun.toward)), Floats{}), all3(t.sun.toward));
  for (std::size_t k = 0; k < t.count; ++k) {
    const image::Lamp& lamp = t.lamp[k];
    const Floats3 along = all3(lamp.position) - place;
    const Floats square = max(dot(along, along), all(1e-6f));
    Floats part = max(dot(normal, along), Floats{}) / (square * sqrt(square));
    if (lamp.per_cosine > 0) part *= in_cone(lamp, along, square);
    add(all3(lamp.color) * part, along);
  }
  gleam.add_sky(t.sky, t.ambient, first_lanes(kLanes));
  return gleam.sent(scattered);
}

/// Returns the light of a surface of this colour, without fog.
MOTES_INLINE Floats3 light_of_surface(const image::SurfaceLight& t, const SurfacePoint& at, Floats3 color) {
  if (t.finish.reflects()) return of_color(sent_by(t, at), color);
  const Floats3 arriving = light_on(t, at);
  return {color.x * arriving.x, color.y * arriving.y, color.z * arriving.z};
}

/// Returns what remains of light on its way to the eye, and the fog in between.
MOTES_INLINE Floats3 through_fog(const image::SurfaceLight& t, Floats3 light, Floats3 place) {
  if (!(t.fog_density > 0)) return light;
  const Floats clear = exp(-min(sqrt(dot(place, place)) * t.fog_density, all(80.0f)));
  return light * clear + all3(t.fog) * (1.0f - clear);
}

/// Returns a colour, 0..1 per channel, of the lower 24 bits, times a gain.
MOTES_INLINE Floats3 color_times(std::uint32_t color, float gain) {
  const float part = gain * (1.0f / 255);
  return {all(static_cast<float>(color & 0xffu) * part), all(static_cast<float>(color >> 8 & 0xffu) * part),
          all(static_cast<float>(color >> 16 & 0xffu) * part)};
}

/// Dims light above white, keeping its hue.
MOTES_INLINE Floats3 at_most_white(Floats3 light) {
  return light * (1.0f / max(max(max(light.x, light.y), light.z), all(1.0f)));
}

}  // namespace motes::MOTES_ISA
