// Light on particles and the shadows that they cast, a vector of particles at a time: types shared by plain code and
// the builds for each instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

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

/// The direction that cards face: along their velocity, or from their orientation. Planes as in ParticlePlanes.
struct CardPlanes {
  bool along_velocity;
  const float* velocity[3];  // m/s
  float velocity_of_all[3];
  const float* orientation[4];
  float orientation_of_all[4];
};

struct LightOnParticles {
  float position[3];
  float color[3];  // light on a surface that faces it at 1 m
  const ShadowMap* shadow;  // null: particles cast none
  const float* in_sight = nullptr;  // the fraction that solids let through, from the first particle on; null: all
};

/// Light and fog that change the colours of a system's particles before they are drawn.
struct LightTask {
  ParticlePlanes particles;
  ParticleWidth width;
  bool lit = false;
  bool bright = false;  // see has_gain()
  bool shaded = false;  // drawing applies the light of sun and sky, so colours get only the ratio to that light
  bool flat = false;    // cards
  CardPlanes cards{};
  bool sunny = false;
  float sun[3];
  const ShadowMap* sun_shadow = nullptr;
  const float* sun_in_sight = nullptr;  // as LightOnParticles::in_sight
  const LightOnParticles* lights = nullptr;
  std::size_t light_count = 0;
  Ambient ambient;
  float shadow = 0;  // of the particles, see Sprite::shadow
  float fog[3]{}, fog_density = 0;  // 1/m; 0: no fog
  bool adds = false;                // additive: the background already includes the fog in front of them
};

struct ShadowTask {
  ParticlePlanes particles;
  ParticleWidth width;
  float shadow;
  float center[3], reach;  // see ShadowGrids::center
};

struct LightLanes {
  /// Writes the colours of particles first .. last - 1 to the first three planes of `to`, which begin with particle
  /// `first`, and their gains to the fourth one if they are bright. Writes whole vectors.
  void (*light)(const LightTask& task, std::size_t first, std::size_t last, float* const* to);

  /// Extends the extent in a grid's space by particles first .. last - 1.
  void (*extend)(const ShadowTask& task, const ShadowSpace& space, std::size_t first, std::size_t last,
                 ShadowExtent& extent);

  /// Adds the particles' optical depths to the sums of a light's grid, see ShadowGrids::numbers.
  void (*add)(const ShadowTask& task, const ShadowSpace& space, std::size_t first, std::size_t last,
              std::int64_t* sums);
};

/// Returns the build for this processor.
const LightLanes& light_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::LightLanes, light_lanes)
