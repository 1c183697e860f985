#include "surfaces/cube_cases.h"

#include <algorithm>
#include <utility>

namespace motes::surfaces {
namespace {

using Polygon = std::vector<std::uint8_t>;

int edge_between(int a, int b) {
  const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  const int low = std::min(a, b);
  const int first = low >> (axis == 0 ? 1 : 0) & 1, second = low >> (axis == 2 ? 1 : 2) & 1;
  return 4 * axis + first + 2 * second;
}

// Returns the corners of a face, counter-clockwise as seen from outside.
std::array<int, 4> corners_of_face(int axis, int side) {
  const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side << axis;
  if (side == 1) return {base, base + u, base + u + v, base + v};
  return {base, base + v, base + u + v, base + u};
}

// Returns the polygons of a case. On each face, counter-clockwise, a line leads from where the inside begins to where
// it ends; the lines of all faces form polygons that face outwards.
std::vector<Polygon> polygons_of(unsigned inside) {
  std::array<int, kEdges> next;
  next.fill(-1);
  const auto is_inside = [&](int corner) { return (inside >> corner & 1u) != 0; };
  for (int face = 0; face < 6; ++face) {
    const auto corners = corners_of_face(face / 2, face % 2);
    const auto corner = [&](int k) { return corners[static_cast<std::size_t>(k % 4)]; };
    for (int k = 0; k < 4; ++k) {
      if (is_inside(corner(k)) || !is_inside(corner(k + 1))) continue;
      int end = k + 1;
      while (is_inside(corner(end + 1))) ++end;
      next[static_cast<std::size_t>(edge_between(corner(k), corner(k + 1)))] =
          edge_between(corner(end), corner(end + 1));
    }
  }
  std::vector<Polygon> polygons;
  for (int start = 0; start < kEdges; ++start) {
    Polygon polygon;
    for (int edge = start; next[static_cast<std::size_t>(edge)] >= 0;) {
      polygon.push_back(static_cast<std::uint8_t>(edge));
      edge = std::exchange(next[static_cast<std::size_t>(edge)], -1);
    }
    if (!polygon.empty()) polygons.push_back(std::move(polygon));
  }
  return polygons;
}

bool share_face(int a, int b) {
  const auto [a0, a1] = corners_of_edge(a);
  const auto [b0, b1] = corners_of_edge(b);
  const int all = a0 & a1 & b0 & b1, none = ~(a0 | a1 | b0 | b1) & 7;
  return all != 0 || none != 0;
}

CubeCase case_of(unsigned inside) {
  CubeCase result;
  for (Polygon& p : polygons_of(inside)) {
    if (p.size() == 3) {
      result.triangles.insert(result.triangles.end(), {p[0], p[1], p[2]});
    } else if (p.size() == 4 && !share_face(p[0], p[2])) {
      result.triangles.insert(result.triangles.end(), {p[0], p[1], p[2], p[0], p[2], p[3]});
    } else if (p.size() == 4 && !share_face(p[1], p[3])) {
      result.triangles.insert(result.triangles.end(), {p[0], p[1], p[3], p[1], p[2], p[3]});
    } else {
      const auto centre = static_cast<std::uint8_t>(kCentre + result.polygons.size());
      for (std::size_t i = 0; i < p.size(); ++i) {
        result.triangles.insert(result.triangles.end(), {p[i], p[(i + 1) % p.size()], centre});
      }
      result.polygons.push_back(std::move(p));
    }
  }
  return result;
}

}  // namespace

std::array<int, 2> corners_of_edge(int edge) {
  const int axis = edge / 4, first = edge & 1, second = edge >> 1 & 1;
  const int low = first << (axis == 0 ? 1 : 0) | second << (axis == 2 ? 1 : 2);
  return {low, low | 1 << axis};
}

const std::array<CubeCase, 256>& cube_cases() {
  static const std::array<CubeCase, 256> cases = [] {
    std::array<CubeCase, 256> all;
    for (unsigned inside = 0; inside < all.size(); ++inside) all[inside] = case_of(inside);
    return all;
  }();
  return cases;
}

}  // namespace motes::surfaces
