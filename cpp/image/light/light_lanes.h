// Light on particles and the shadows that they cast, a vector of particles at a time: types shared by plain code and
// the builds for each instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/light/lamps.h"
#include "image/light/shadow_grid.h"
#include "image/light/sky.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// Particles as planes of floats. Where a plane is null, all particles have the value `..._of_all`.
struct ParticlePlanes {
  const float* position[3];
  const float* color[3];
  float color_of_all[3];
  const float* alpha;
  float alpha_of_all;
  const float* size;  // m
  float size_of_all;
};

/// The width of particles: from their size in metres, or in proportion to the distance from the eye.
struct ParticleWidth {
  bool own;          // from their size; otherwise `per_metre` times the distance
  float per_metre;   // diameter at a distance of 1 m, m
  float eye[3];
};

/// What the light falls on: a ball, or the visible side of a card, which faces along its velocity or as its orientation
/// says. Planes as in ParticlePlanes.
struct LitShape {
  enum class Kind : std::uint8_t { ball, card_along_velocity, card };

  Kind kind;
  const float* velocity[3];  // m/s
  float velocity_of_all[3];
  const float* orientation[4];
  float orientation_of_all[4];
};

/// What keeps a light from particles.
struct Obstacles {
  const ShadowMap* shadow = nullptr;  // of particles; null: they cast none
  const float* in_sight = nullptr;  // the fraction that solids let through, from the first particle on; null: all
};

struct LightOnParticles {
  Lamp lamp;
  Obstacles obstacles;
};

/// The light on lit particles.
struct Lighting {
  LitShape shape{};
  Sun sun;
  Obstacles sun_obstacles;
  const LightOnParticles* lights = nullptr;
  std::size_t light_count = 0;
  Ambient ambient;
  const SkyDepths* sky = nullptr;  // null: nothing keeps the sky's light from particles
  float own_shadow = 0;   // see Sprite::shadow; 0 also where it is sharp
  float reach = 0.5f;     // of a particle from its middle, in its widths
  bool relative = false;  // drawing applies the light, so colours get only the part of it that obstacles leave
  bool gains = false;     // see has_gain()
};

/// Light and fog that change the colours of a system's particles before they are drawn.
struct LightTask {
  ParticlePlanes particles;
  ParticleWidth width;
  const Lighting* lighting = nullptr;  // null: the particles are not lit
  float fog[3]{}, fog_density = 0;  // 1/m; 0: no fog
  bool adds = false;  // whether light adds up: then the background already includes the fog in front of them
};

struct ShadowTask {
  ParticlePlanes particles;
  ParticleWidth width;
  float shadow;
};

/// A ball in a page of a depth map: its centre in the axes of the plane, m, and the place of the page's first texel, m
/// or tangents of angles, as those of the space.
struct DepthBall {
  bool point;
  float center[3];
  float square;  // of its radius
  float left, top, step;
  int columns[2], rows[2];  // first and last that it may cover
};

struct LightLanes {
  /// Writes the colours of particles first .. last - 1 to the first three planes of `to`, which begin with particle
  /// `first`, and their gains, if wanted, to the fourth one. Writes whole vectors.
  void (*light)(const LightTask& task, std::size_t first, std::size_t last, float* const* to);

  /// Adds the particles' optical depths to the sums of a light's grid, see ShadowGrids::numbers. Returns a bit per box
  /// to which any were added.
  unsigned (*add)(const ShadowTask& task, const ShadowSpace& space, std::size_t first, std::size_t last,
                  std::int64_t* sums);

  /// Keeps a ball in the texels of a page where it is the nearest.
  void (*keep_ball)(const DepthBall& ball, float* texels);

  /// Replaces optical depths by the part of the light that they let through. `count`: a multiple of 16.
  void (*let_through)(float* depths, std::size_t count);
};

/// Returns the build for this processor.
const LightLanes& light_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::LightLanes, light_lanes)
