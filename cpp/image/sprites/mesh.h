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

  static constexpr std::tuple kMembers{base::Member{"mesh", &MeshSprite::mesh},
                                       base::Member{"facing", &MeshSprite::facing}};
  bool operator==(const MeshSprite&) const = default;

  /// Returns the part that painters need: records carry the rotation.
  MeshSprite painted() const { return {mesh}; }
};

inline void check(const MeshSprite& sprite) {
  if (sprite.mesh == 0) base::refuse("sprite.mesh", "the key of a mesh", "0");
  const std::size_t triangles = meshes::mesh(sprite.mesh)->triangles.size() / 3;
  if (triangles > kMostSpriteTriangles) {
    base::refuse("sprite.mesh", "of at most " + std::to_string(kMostSpriteTriangles) + " triangles",
                 std::to_string(triangles));
  }
}

}  // namespace motes::image
