// Light and fog on the particles of a system, and which particles throw shadows: from a view to what kernels take.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "image/light/light_lanes.h"
#include "image/scene.h"

namespace motes::image {

/// Writes which part of each light is in sight of particles first .. last - 1: planes `stride` floats apart of the sun,
/// then of each of the view's lights. Whole vectors are written.
using InSight = std::function<void(const ParticlePlanes& particles, const ParticleWidth& width, std::size_t first,
                                   std::size_t last, float* to, std::size_t stride)>;

/// What the colours of a system's particles become; null where they stay what they are.
class ParticleLight {
 public:
  /// `shadows`: of the view; null: particles throw none. `in_sight`: what solids leave; empty: they throw none either.
  static std::unique_ptr<const ParticleLight> of(const Sprite& sprite, const View& view, const ShadowGrids* shadows,
                                                 InSight in_sight = {});

  /// Whether it also writes gains: see has_gain().
  bool has_gain() const { return task_.bright; }

  /// Writes the colours of particles first .. last - 1 to three planes `stride` floats apart, and their gains to a
  /// fourth one.
  void light(const Drawn& particles, std::size_t first, std::size_t last, float* to, std::size_t stride) const;

 private:
  LightTask task_;
  std::vector<LightOnParticles> lights_;
  InSight in_sight_;
};

/// Shadows of a system's particles, of particles first .. last - 1.
class ParticleShadows {
 public:
  ParticleShadows(const Sprite& sprite, const View& view, const ShadowGrids& grids, const Drawn& particles);
  void extend(std::size_t first, std::size_t last, std::vector<ShadowExtent>& extents) const;
  /// `sums`: of all lights.
  void add(std::size_t first, std::size_t last, std::int64_t* sums) const;

 private:
  ShadowTask task_;
  const ShadowGrids* grids_;
};

}  // namespace motes::image
