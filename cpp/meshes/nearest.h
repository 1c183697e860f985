// Finds the place of a closed surface that is nearest to a point.
#pragma once

#include <cstdint>

#include "meshes/bvh.h"
#include "meshes/surface.h"

namespace motes::meshes {

/// The nearest place of a triangle, and the part that it is on: the inside, corner k, or the edge from corner k to
/// corner k + 1.
struct NearestPoint {
  Vector point{};
  enum class Part : std::uint8_t { inside, corner, edge } part = Part::inside;
  std::uint8_t k = 0;
};

/// Returns the nearest place of the triangle (C. Ericson, Real-Time Collision Detection, 5.1.5).
NearestPoint nearest_on(const Vector& a, const Vector& b, const Vector& c, const Vector& point);

class SignedDistance {
 public:
  /// The surface must be closed and outlive this. `sign`: -1 if its triangles face inwards, else 1.
  SignedDistance(const Surface& surface, double sign);

  /// Returns the distance to the surface, m, negative inside; `limit` if it is not below that.
  double distance(const Vector& point, double limit) const;

 private:
  Vector outward(std::size_t triangle, const NearestPoint& place) const;

  const Surface& surface_;
  double sign_;
  Normals normals_;
  Bvh tree_;
};

}  // namespace motes::meshes
