// The triangles of a mesh in a tree of boxes (BVH), in which rays find them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/vectors.h"
#include "meshes/assets.h"

namespace motes::meshes {

struct BvhNode {
  float low[3];
  std::uint32_t first;  // of the triangles of a leaf; elsewhere of the two children
  float high[3];
  std::uint32_t count;  // of the triangles of a leaf; 0 elsewhere
};

struct BvhTriangle {
  float corner[3][3];  // m
  float normal[3];     // unit
};

/// The deepest tree that is built: what a ray needs to remember.
inline constexpr int kMaxBvhDepth = 60;

/// Nodes and triangles depend on the mesh alone. A child's box lies within its parent's. Triangles without an area are
/// left out: they are invisible.
struct Bvh {
  std::vector<BvhNode> nodes;  // the first is the root
  std::vector<BvhTriangle> triangles;
  std::vector<std::uint32_t> origin;  // of each triangle: its number in the mesh
  std::vector<float> colors;  // nine of each triangle: linear RGB of its corners; empty: they have none
  Ball ball;
};

Bvh build_bvh(const Mesh& mesh);

/// The tree of a kept mesh, built once. Thread-safe. Throws std::invalid_argument where there is no such mesh.
std::shared_ptr<const Bvh> bvh_of(AssetKey mesh);

}  // namespace motes::meshes
