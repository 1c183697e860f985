// Draws what casts shadows with edges into the depth maps of lights: balls, cards and meshes.
#pragma once

#include <cstddef>
#include <vector>

#include "image/light/depth_map.h"
#include "image/light/image_levels.h"
#include "image/light/light_lanes.h"
#include "image/mesh_corners.h"
#include "image/scene.h"

namespace motes::image {

/// The particles of a system that casts_sharply(). Points, discs and pictures that face the camera are balls; of cards,
/// what is at least half opaque. The particle's alpha must be above 0. A lamp within a ball is not shaded by it.
class DepthCasters {
 public:
  DepthCasters(const Sprite& sprite, const View& view, const Drawn& particles);

  /// Draws particles first .. last - 1 into the maps of all lights.
  void draw(std::size_t first, std::size_t last, std::vector<DepthMap>& maps) const;

 private:
  struct Stance;
  struct Triangle;

  double width_of(std::size_t i, const Vector& place) const;
  Stance stance_of(std::size_t i, double scale) const;
  template <class Planes>
  void draw_mesh(const Vector& place, const Stance& stance, const Planes& planes, DepthMap& map) const;
  template <class Planes>
  void draw_card(std::size_t i, const Vector& place, const Stance& stance, const Planes& planes, DepthMap& map) const;

  const Sprite* sprite_;
  const Drawn* particles_;
  ParticleWidth width_;
  const MeshCorners* mesh_ = nullptr;
  const ImageLevels* picture_ = nullptr;  // of cards
  const LightLanes* lanes_;
};

}  // namespace motes::image
