// Rays through a mesh: a vector of rays traverses its BVH together.
//
// Which triangle a ray meets does not depend on the other rays of its vector: a triangle counts only for rays that pass
// through the box of its leaf, distances are clamped to this box, and all comparisons with boxes are monotonic in their
// bounds. Hence a box that is skipped has no triangle that would count.
#pragma once

#include "image/raycast/cast_rays.h"

namespace motes::MOTES_ISA {

/// Convert a direction from the world's axes to those of a mesh, and back.
MOTES_INLINE Floats3 into_mesh(const image::CastSolid& solid, Floats3 v) {
  const float* axes = solid.value + 3;
  if (!solid.turned) return v;
  return {dot(v, all3(axes)), dot(v, all3(axes + 3)), dot(v, all3(axes + 6))};
}
MOTES_INLINE Floats3 out_of_mesh(const image::CastSolid& solid, Floats3 v) {
  const float* axes = solid.value + 3;
  if (!solid.turned) return v;
  return all3(axes) * v.x + all3(axes + 3) * v.y + all3(axes + 6) * v.z;
}
MOTES_INLINE Rays rays_in_mesh(const image::CastSolid& solid, const Rays& rays) {
  return {into_mesh(solid, rays.from) + all3(solid.value), into_mesh(solid, rays.along)};
}

class MeshRays {
 public:
  MOTES_INLINE MeshRays(const image::CastSolid& solid, const Rays& rays)
      : nodes_(solid.nodes), triangles_(solid.triangles), rays_(rays_in_mesh(solid, rays)) {
    inverse_ = {1.0f / not_zero(rays_.along.x), 1.0f / not_zero(rays_.along.y), 1.0f / not_zero(rays_.along.z)};
    // Enlarge boxes by the rounding error of a ray at the mesh's distance.
    const meshes::BvhNode& root = nodes_[0];
    const Floats3 low = all3(root.low) - rays_.from, high = all3(root.high) - rays_.from;
    const Floats margin = (max(abs(low.x), abs(high.x)) + max(abs(low.y), abs(high.y)) + max(abs(low.z), abs(high.z)) +
                           abs(rays_.from.x) + abs(rays_.from.y) + abs(rays_.from.z)) *
                          1e-6f;
    below_ = {rays_.from.x + margin, rays_.from.y + margin, rays_.from.z + margin};
    above_ = {rays_.from.x - margin, rays_.from.y - margin, rays_.from.z - margin};
  }

  /// Returns the nearest crossing; of several at the same distance, that with the first triangle.
  RayHit nearest(Floats near, Floats far) const {
    RayHit found{Mask{}, far, Ints{}};
    walk([&](const meshes::BvhNode& node) {
      Floats enter, leave;
      const Mask open = inside(node, near, found.distance, enter, leave);
      if (!any(open)) return false;
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        Floats distance;
        Mask met = open & meet(i, near, distance);
        if (!any(met)) continue;
        distance = max(min(distance, leave), enter);
        const Ints number = Ints{} + static_cast<std::int32_t>(i);
        met &= (distance < found.distance) | (found.met & (distance == found.distance) & (number < found.face));
        found.distance = select(met, distance, found.distance);
        found.face = (number & met) | (found.face & ~met);
        found.met |= met;
      }
      return true;
    });
    return found;
  }

  /// Returns which rays meet any triangle between `near` and `far`. Only the lanes of `open` matter.
  Mask blocked(Floats near, Floats far, Mask open) const {
    walk([&](const meshes::BvhNode& node) {
      Floats enter, leave;
      const Mask here = open & inside(node, near, far, enter, leave);
      if (!any(here)) return false;
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        Floats distance;
        const Mask met = here & meet(i, near, distance);
        open &= ~(met & (max(min(distance, leave), enter) < far));
      }
      return true;
    });
    return ~open;
  }

 private:
  // Returns which rays pass through a node's box between `near` and `far`, and where they enter and leave it.
  MOTES_INLINE Mask inside(const meshes::BvhNode& node, Floats near, Floats far, Floats& enter, Floats& leave) const {
    const Floats x0 = (node.low[0] - below_.x) * inverse_.x, x1 = (node.high[0] - above_.x) * inverse_.x;
    const Floats y0 = (node.low[1] - below_.y) * inverse_.y, y1 = (node.high[1] - above_.y) * inverse_.y;
    const Floats z0 = (node.low[2] - below_.z) * inverse_.z, z1 = (node.high[2] - above_.z) * inverse_.z;
    enter = max(max(min(x0, x1), min(y0, y1)), min(z0, z1));
    leave = min(min(max(x0, x1), max(y0, y1)), max(z0, z1));
    return (enter <= leave) & (leave > near) & (enter <= far);
  }

  MOTES_INLINE Mask meet(std::uint32_t number, Floats near, Floats& distance) const {
    const meshes::BvhTriangle& triangle = triangles_[number];
    const Floats3 normal = all3(triangle.normal);
    distance = dot(normal, all3(triangle.corner[0]) - rays_.from) / dot(normal, rays_.along);
    return pass_through(triangle.corner, rays_) & (distance > near) & (distance <= __FLT_MAX__);
  }

  // Calls `use` for nodes from the root down, visiting the children of a node only if it returns true.
  template <class Use>
  MOTES_INLINE void walk(const Use& use) const {
    std::uint32_t stack[meshes::kMaxBvhDepth + 4];
    std::size_t left = 0;
    stack[left++] = 0;
    while (left != 0) {
      const meshes::BvhNode& node = nodes_[stack[--left]];
      if (!use(node) || node.count != 0) continue;
      const bool second_first = second_is_nearer(nodes_[node.first], nodes_[node.first + 1]);
      stack[left++] = node.first + (second_first ? 0 : 1);
      stack[left++] = node.first + (second_first ? 1 : 0);
    }
  }

  // Returns whether the second box is nearer for the first ray. A wrong order only costs time.
  MOTES_INLINE bool second_is_nearer(const meshes::BvhNode& first, const meshes::BvhNode& second) const {
    float ahead = 0;
    ahead += (second.low[0] + second.high[0] - first.low[0] - first.high[0]) * rays_.along.x[0];
    ahead += (second.low[1] + second.high[1] - first.low[1] - first.high[1]) * rays_.along.y[0];
    ahead += (second.low[2] + second.high[2] - first.low[2] - first.high[2]) * rays_.along.z[0];
    return ahead < 0;
  }

  const meshes::BvhNode* nodes_;
  const meshes::BvhTriangle* triangles_;
  Rays rays_;
  Floats3 inverse_, below_, above_;
};

/// Returns the normals of the triangles that were met, one per lane.
MOTES_INLINE Floats3 mesh_normals(const meshes::BvhTriangle* triangles, const RayHit& crossing) {
  Floats3 normal{};
  for (std::size_t i = 0; i < kLanes; ++i) {
    if (crossing.met[i] == 0) continue;
    const float* from = triangles[static_cast<std::size_t>(crossing.face[i])].normal;
    normal.x[i] = from[0];
    normal.y[i] = from[1];
    normal.z[i] = from[2];
  }
  return normal;
}

}  // namespace motes::MOTES_ISA
