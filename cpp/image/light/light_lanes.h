// Light on particles and the shadows that they throw, a vector of particles at a time: types shared by plain code and
// the per-ISA builds.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/light/shadow_grid.h"
#include "image/light/sky.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// Particles as planes of floats; null: the value beside it holds for all.
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
  bool own;          // from their size
  float per_metre;   // else: m of diameter per m of distance
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
  float color[3];  // on a surface that faces it at 1 m
  const ShadowMap* shadow;  // null: particles throw none
  const float* in_sight = nullptr;  // the fraction that solids let through, from the first particle on; null: all
};

/// What changes the colours of a system's particles before they are drawn.
struct LightTask {
  ParticlePlanes particles;
  ParticleWidth width;
  bool lit = false;
  bool bright = false;  // see has_gain()
  bool shaded = false;  // by their kind, as the sun and the sky do alone: only what differs from that counts
  bool flat = false;    // cards
  CardPlanes cards{};
  bool sunny = false;
  float sun[3];
  const ShadowMap* sun_shadow = nullptr;
  const float* sun_in_sight = nullptr;  // as LightOnParticles::in_sight
  const LightOnParticles* lights = nullptr;
  std::size_t light_count = 0;
  Ambient ambient;
  float shadow = 0;  // the particles' own
  float fog[3]{}, fog_density = 0;  // 1/m; 0: there is none
  bool adds = false;                // additive: the fog in front of it is part of the background already
};

struct ShadowTask {
  ParticlePlanes particles;
  ParticleWidth width;
  float shadow;
  float center[3], reach;  // see ShadowGrids::center
};

struct LightLanes {
  /// Writes the colours of particles first .. last - 1 to `to`, three planes that begin with the first one, and to a
  /// fourth one their gains where they are bright. Whole vectors are written.
  void (*light)(const LightTask& task, std::size_t first, std::size_t last, float* const* to);

  /// Extends the extent in a grid's space by particles first .. last - 1.
  void (*extend)(const ShadowTask& task, const ShadowSpace& space, std::size_t first, std::size_t last,
                 ShadowExtent& extent);

  /// Adds the particles' optical depths to the sums of a light's grid, see ShadowGrids::numbers.
  void (*add)(const ShadowTask& task, const ShadowSpace& space, std::size_t first, std::size_t last,
              std::int64_t* sums);
};

/// The build that suits this processor.
const LightLanes& light_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::LightLanes, light_lanes)
