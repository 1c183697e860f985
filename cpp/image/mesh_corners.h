// The triangles of a mesh that is drawn as a sprite.
#pragma once

#include <cstddef>
#include <vector>

#include "meshes/assets.h"

namespace motes::image {

/// Most triangles of a mesh that is drawn as a sprite: each instance goes through all of them, in each of its tiles.
inline constexpr std::size_t kMostSpriteTriangles = 10000;

struct MeshCorners {
  /// Twelve planes of `room` floats: x, y, z of the first corner of each triangle, of the second, of the third, m, and
  /// of its normal, a unit vector. Triangles beyond the last are all 0.
  std::vector<float> planes;
  /// Nine planes of `room` floats: linear red, green, blue of the first corner, of the second, of the third, 0..1.
  /// Empty: the mesh has no colours.
  std::vector<float> colors;
  int triangles = 0;
  int room = 0;  // whole vectors of any width
  /// The surface has an inside: no triangle is seen from behind.
  bool closed = false;
};

/// Returns the triangles of a mesh, computed at first use and kept until the process ends. Thread-safe. Throws
/// std::invalid_argument if this process has no such mesh.
const MeshCorners& mesh_corners(meshes::AssetKey key);

/// Returns how far the farthest vertex is from the mesh's origin, m.
float reach_of_mesh(meshes::AssetKey key);

}  // namespace motes::image
