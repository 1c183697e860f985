#include "meshes/nearest.h"

#include <algorithm>
#include <cmath>

#include "base/vectors.h"

namespace motes::meshes {
namespace {

// NOLINTBEGIN(misc-unused-using-decls): it does not see that operators are used
// NOLINTEND(misc-unused-using-decls)
using Part = NearestPoint::Part;

// Returns the surface as a mesh without slivers, across which their neighbours meet. `number`: the number of each
// triangle in the surface.
Mesh mesh_of(const Surface& surface, const Normals& normals, std::vector<std::uint32_t>& number) {
  Mesh mesh;
  for (const Vector& v : surface.vertices) {
    for (const double x : v) mesh.vertices.push_back(static_cast<float>(x));  // exact: it was a float
  }
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    if (normals.triangle[t] == Vector{}) continue;
    mesh.triangles.insert(mesh.triangles.end(), surface.triangles[t].begin(), surface.triangles[t].end());
    number.push_back(t);
  }
  return mesh;
}

double square_to_box(const BvhNode& node, const Vector& point) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double off = std::max({node.low[i] - point[i], point[i] - node.high[i], 0.0});
    sum += off * off;
  }
  return sum;
}

}  // namespace

NearestPoint nearest_on(const Vector& a, const Vector& b, const Vector& c, const Vector& point) {
  const Vector ab = b - a, ac = c - a, ap = point - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {a, Part::corner, 0};
  const Vector bp = point - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {b, Part::corner, 1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + ab * (d1 / (d1 - d3)), Part::edge, 0};
  const Vector cp = point - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {c, Part::corner, 2};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + ac * (d2 / (d2 - d6)), Part::edge, 2};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return {b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), Part::edge, 1};
  }
  const double scale = 1 / (va + vb + vc);
  return {a + ab * (vb * scale) + ac * (vc * scale), Part::inside, 0};
}

SignedDistance::SignedDistance(const Surface& surface, double sign)
    : surface_(surface), sign_(sign), normals_(normals_of(surface)) {
  std::vector<std::uint32_t> number;
  const Mesh mesh = mesh_of(surface, normals_, number);
  tree_ = build_bvh(mesh);
  for (std::uint32_t& triangle : tree_.origin) triangle = number[triangle];
}

Vector SignedDistance::outward(std::size_t triangle, const NearestPoint& place) const {
  if (place.part == Part::inside) return normals_.triangle[triangle];
  if (place.part == Part::edge) return normals_.edge[triangle][place.k];
  return normals_.vertex[surface_.triangles[triangle][place.k]];
}

double SignedDistance::distance(const Vector& point, double limit) const {
  double least = limit * limit;
  double side = 0;
  std::uint32_t stack[kMaxBvhDepth + 4];
  std::size_t left = 0;
  if (!tree_.nodes.empty() && square_to_box(tree_.nodes[0], point) < least) stack[left++] = 0;
  while (left != 0) {
    const BvhNode& node = tree_.nodes[stack[--left]];
    if (square_to_box(node, point) >= least) continue;
    if (node.count == 0) {
      const double first = square_to_box(tree_.nodes[node.first], point);
      const double second = square_to_box(tree_.nodes[node.first + 1], point);
      const std::uint32_t nearer = second < first ? 1 : 0;
      stack[left++] = node.first + 1 - nearer;
      stack[left++] = node.first + nearer;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const std::uint32_t triangle = tree_.origin[i];
      const auto& [a, b, c] = surface_.triangles[triangle];
      const NearestPoint place = nearest_on(surface_.vertices[a], surface_.vertices[b], surface_.vertices[c], point);
      const Vector off = point - place.point;
      const double square = dot(off, off);
      if (square >= least) continue;
      least = square;
      side = dot(off, outward(triangle, place));
    }
  }
  const double distance = std::sqrt(least);
  return side * sign_ < 0 ? -distance : distance;
}

}  // namespace motes::meshes
