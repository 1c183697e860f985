// The triangles of a mesh that is drawn as a sprite.
#pragma once

#include <vector>

#include "meshes/assets.h"

namespace motes::image {

struct MeshCorners {
  /// Twelve planes of `room` floats: x, y, z of each triangle's first, second and third corner, m, and of its unit
  /// normal. Triangles beyond the last are all 0.
  std::vector<float> planes;
  /// Nine planes of `room` floats: linear red, green, blue, 0..1, of the first, second and third corner. Empty: the
  /// mesh has no colours.
  std::vector<float> colors;
  /// Nine planes of normals and six of places on a picture (see meshes::Mesh), in the same order. Empty: it has none.
  std::vector<float> normals, uv;
  int triangles = 0;
  int room = 0;  // `triangles` rounded up to whole vectors of any width
  /// The surface encloses a volume, so no triangle is seen from behind.
  bool closed = false;
};

/// Returns the triangles of a mesh, computed at first use and kept until the process ends. Thread-safe. Throws
/// std::invalid_argument if this process has no such mesh.
const MeshCorners& mesh_corners(meshes::AssetKey key);

/// Returns the distance of the farthest vertex from the mesh's origin, m.
float reach_of_mesh(meshes::AssetKey key);

}  // namespace motes::image
