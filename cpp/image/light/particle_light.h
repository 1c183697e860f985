// Light and fog on the particles of a system, and the shadows that they cast.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "image/light/light_lanes.h"
#include "image/scene.h"

namespace motes::image {

/// Writes the part of each light that is visible from particles first .. last - 1: planes `stride` floats apart, of the
/// sun, then of each of the view's lights. Writes whole vectors.
using InSight = std::function<void(const ParticlePlanes& particles, const ParticleWidth& width, std::size_t first,
                                   std::size_t last, float* to, std::size_t stride)>;

/// Returns the width of particles. If the sprite's size is in pixels, their width in metres grows with the distance.
ParticleWidth particle_width(const Sprite& sprite, const View& view);

/// Applies light and fog to the colours of a system's particles.
class ParticleLight {
 public:
  /// Returns null if the colours do not change. `shadows`: of particles in the view; null: none. `in_sight`: the part
  /// of each light that solids leave visible; empty: solids cast none.
  static std::unique_ptr<const ParticleLight> of(const Sprite& sprite, const View& view, const ShadowGrids* shadows,
                                                 InSight in_sight = {});

  /// Returns whether light() also writes gains: see image::has_gain().
  bool has_gain() const { return lighting_.gains; }

  /// Writes the colours of particles first .. last - 1 to three planes `stride` floats apart, and their gains, if any,
  /// to a fourth one.
  void light(const Drawn& particles, std::size_t first, std::size_t last, float* to, std::size_t stride) const;

 private:
  void set_lighting(const Sprite& sprite, const View& view, const ShadowGrids* shadows, InSight in_sight);

  LightTask task_;
  bool lit_ = false;
  Lighting lighting_;
  std::vector<LightOnParticles> lights_;
  InSight in_sight_;
};

/// Adds the shadows of a system's particles first .. last - 1 to the grids of all lights.
class ParticleShadows {
 public:
  ParticleShadows(const Sprite& sprite, const View& view, const ShadowGrids& grids, const Drawn& particles);
  /// Adds the particles' optical depths to `sums`, those of all lights, and marks the boxes that have any: see
  /// ShadowGrids::resolve.
  void add(std::size_t first, std::size_t last, std::int64_t* sums, std::vector<unsigned>& boxes) const;

 private:
  ShadowTask task_;
  const ShadowGrids* grids_;
};

}  // namespace motes::image
