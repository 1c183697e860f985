// The triangles of a mesh in a tree of boxes (BVH), to find those that a ray hits.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/vectors.h"
#include "meshes/assets.h"

namespace motes::meshes {

struct BvhNode {
  float low[3];
  std::uint32_t first;  // first triangle of a leaf; of other nodes, first of the two children
  float high[3];
  std::uint32_t count;  // number of triangles of a leaf; 0 for other nodes
};

struct BvhTriangle {
  float corner[3][3];  // m
  float normal[3];     // unit
};

/// Depth of the deepest tree that is built: the stack that a ray needs.
inline constexpr int kMaxBvhDepth = 60;

/// Nodes and triangles depend only on the mesh. A child's box is within its parent's. Triangles without an area are
/// left out: they are invisible.
struct Bvh {
  std::vector<BvhNode> nodes;  // the first is the root
  std::vector<BvhTriangle> triangles;
  std::vector<std::uint32_t> origin;  // number of each triangle in the mesh
  std::vector<float> colors;  // linear RGB of each triangle's corners, nine numbers; empty: no colours
  std::vector<float> uv;  // place of each triangle's corners on a picture, six numbers; empty: none
  std::vector<float> normals;  // of each triangle's corners, nine numbers; empty: those of the triangles
  Ball ball;
};

Bvh build_bvh(const Mesh& mesh);

/// Returns the tree of a kept mesh, built once. Thread-safe. Throws std::invalid_argument if there is no such mesh.
std::shared_ptr<const Bvh> bvh_of(AssetKey mesh);

}  // namespace motes::meshes
