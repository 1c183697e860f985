// mesh: an instance of a mesh, scaled by the particle's size.
#pragma once

#include <cstddef>
#include <string>
#include <tuple>

#include "base/checks.h"
#include "base/members.h"
#include "image/sprites/facing.h"
#include "meshes/assets.h"

namespace motes::image {

/// Greatest number of triangles of a mesh that is drawn as a sprite: each instance visits all of them in each tile.
inline constexpr std::size_t kMostSpriteTriangles = 10000;

struct MeshSprite {
  meshes::AssetKey mesh = 0;
  Facing facing = Facing::orientation;
  meshes::AssetKey picture = 0;  // not 0: a picture of light that multiplies the colour, at the mesh's uv

  static constexpr std::tuple kMembers{base::Member{"mesh", &MeshSprite::mesh},
                                       base::Member{"facing", &MeshSprite::facing},
                                       base::Member{"picture", &MeshSprite::picture}};
  bool operator==(const MeshSprite&) const = default;

  /// Returns the part that painters need: records carry the rotation.
  MeshSprite painted() const { return {mesh, Facing::orientation, picture}; }
};

inline void check(const MeshSprite& sprite) {
  if (sprite.mesh == 0) base::refuse("sprite.mesh", "the key of a mesh", "0");
  if (sprite.picture != 0 && (!meshes::has_picture(sprite.picture) || meshes::mesh(sprite.mesh)->uv.empty())) {
    base::refuse("sprite.picture", "the key of a picture, for a mesh with uv", std::to_string(sprite.picture));
  }
  const std::size_t triangles = meshes::mesh(sprite.mesh)->triangles.size() / 3;
  if (triangles > kMostSpriteTriangles) {
    base::refuse("sprite.mesh", "of at most " + std::to_string(kMostSpriteTriangles) + " triangles",
                 std::to_string(triangles));
  }
}

}  // namespace motes::image
