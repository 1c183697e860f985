#include "meshes/surface.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "base/vectors.h"

namespace motes::meshes {
namespace {

// NOLINTBEGIN(misc-unused-using-decls): it does not see that operators are used
// NOLINTEND(misc-unused-using-decls)

// A triangle whose height is below this part of its longest side is a sliver: its direction is noise.
constexpr double kSliver = 1e-6;

// Finds the first vertex within `reach` of a point.
class VertexIndex {
 public:
  VertexIndex(const std::vector<Vector>& vertices, double reach) : vertices_(vertices), reach_(reach) {}

  // Returns the number of the vertex at `point`: a new one, `next`, if there is none within reach.
  std::uint32_t number(const Vector& point, std::uint32_t next) {
    std::uint32_t found = next;
    for (int corner = 0; corner < 8; ++corner) {
      const auto cell = cells_.find(cell_of(point, corner));
      if (cell == cells_.end()) continue;
      for (const std::uint32_t other : cell->second) {
        if (length(vertices_[other] - point) <= reach_) found = std::min(found, other);
      }
    }
    if (found == next) cells_[cell_of(point, -1)].push_back(next);
    return found;
  }

 private:
  // Returns a hash of the cell of the point itself (`corner` -1) or of a corner of the cube within its reach. Cells
  // with the same hash only cost time.
  std::uint64_t cell_of(const Vector& point, int corner) const {
    std::uint64_t cell = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double shift = corner < 0 ? 0 : (corner >> i & 1) != 0 ? reach_ : -reach_;
      const auto along = static_cast<std::int64_t>(std::floor((point[i] + shift) / (4 * reach_)));
      cell = (cell ^ static_cast<std::uint64_t>(along)) * 0x9e3779b97f4a7c15u;
      cell ^= cell >> 29;
    }
    return cell;
  }

  const std::vector<Vector>& vertices_;
  double reach_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

// Returns the distance, m, up to which two vertices are merged: a millionth of the extent, or the rounding of the
// coordinates.
double weld_distance(const Mesh& mesh) {
  Vector low{}, high{};
  low.fill(std::numeric_limits<double>::max());
  high.fill(std::numeric_limits<double>::lowest());
  double far = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const double x = mesh.vertices[i];
    low[i % 3] = std::min(low[i % 3], x);
    high[i % 3] = std::max(high[i % 3], x);
    far = std::max(far, std::fabs(x));
  }
  const double extent = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  return std::max({1e-6 * extent, 0x1p-22 * far, 1e-30});
}

// One side of an edge: a triangle, and its corner at which the edge starts.
struct Side {
  std::uint32_t low, high;  // the vertices
  std::uint32_t triangle;
  std::uint8_t corner;
  bool upward;  // from low to high
};

// Returns all sides, sorted so that those of an edge are adjacent.
std::vector<Side> sides_of(const Surface& surface) {
  std::vector<Side> sides;
  sides.reserve(3 * surface.triangles.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t from = surface.triangles[t][k], to = surface.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), t, k, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::array{a.low, a.high, a.triangle, std::uint32_t{a.corner}} <
           std::array{b.low, b.high, b.triangle, std::uint32_t{b.corner}};
  });
  return sides;
}

// Calls use(first, last) for the sides of each edge.
template <class Use>
void each_edge(const std::vector<Side>& sides, const Use& use) {
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    while (last < sides.size() && sides[last].low == sides[first].low && sides[last].high == sides[first].high) ++last;
    use(first, last);
  }
}

// The edges with one kind of fault.
struct Fault {
  std::size_t count = 0;
  std::uint32_t low = 0, high = 0;  // vertices of the first one

  void add(const Side& side) {
    if (count++ == 0) low = side.low, high = side.high;
  }
};

std::string text(const Vector& v) {
  char digits[96];
  std::snprintf(digits, sizeof digits, "(%.4g, %.4g, %.4g)", v[0], v[1], v[2]);
  return digits;
}

std::string said(const Surface& surface, const Fault& fault, const std::string& one, const std::string& many) {
  return std::to_string(fault.count) + " " + (fault.count == 1 ? one : many) + ", the first from " +
         text(surface.vertices[fault.low]) + " to " + text(surface.vertices[fault.high]);
}

// Returns the angle between two unit vectors, radians: 2 atan(|a - b| / |a + b|), whose angle is halved until a short
// series is enough. The C library's functions differ between processors.
double angle_between(const Vector& a, const Vector& b) {
  const double apart = length(a - b), together = length(a + b);
  if (!(together > 0)) return std::numbers::pi;
  if (apart > together) return std::numbers::pi - angle_between(a, b * -1.0);
  double t = apart / together;  // 0..1
  for (int i = 0; i < 3; ++i) t = t / (1 + std::sqrt(1 + t * t));
  const double square = t * t;
  double sum = 0;
  for (int k = 17; k > 0; k -= 2) sum = 1.0 / k - square * sum;
  return 16 * t * sum;
}

// Returns the unit normal of a triangle; zero for a sliver.
Vector unit_normal(const Vector& a, const Vector& b, const Vector& c) {
  const Vector normal = cross(b - a, c - a);
  const double longest = std::max({length(b - a), length(c - b), length(a - c)});
  const double size = length(normal);
  if (!(size > kSliver * longest * longest)) return {};
  return normal * (1 / size);
}

}  // namespace

Surface weld(const Mesh& mesh) {
  Surface surface;
  std::vector<std::uint32_t> number;
  VertexIndex places(surface.vertices, weld_distance(mesh));
  for (std::size_t i = 0; i + 2 < mesh.vertices.size(); i += 3) {
    const Vector point{mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]};
    const auto next = static_cast<std::uint32_t>(surface.vertices.size());
    number.push_back(places.number(point, next));
    if (number.back() == next) surface.vertices.push_back(point);
  }
  for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
    const std::uint32_t a = number[mesh.triangles[i]], b = number[mesh.triangles[i + 1]],
                        c = number[mesh.triangles[i + 2]];
    if (a == b || b == c || c == a) continue;
    surface.triangles.push_back({a, b, c});
    surface.origin.push_back(static_cast<std::uint32_t>(i / 3));
  }
  return surface;
}

std::string opening(const Surface& surface) {
  if (surface.triangles.empty()) return "no triangle with an area";
  const std::vector<Side> sides = sides_of(surface);
  Fault open, crowded, turned;
  each_edge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first == 1) open.add(sides[first]);
    if (last - first > 2) crowded.add(sides[first]);
    if (last - first == 2 && sides[first].upward == sides[first + 1].upward) turned.add(sides[first]);
  });
  if (open.count != 0) return said(surface, open, "open edge", "open edges");
  if (crowded.count != 0) {
    return said(surface, crowded, "edge of more than two triangles", "edges of more than two triangles");
  }
  if (turned.count != 0) {
    return said(surface, turned, "edge between triangles that face opposite sides",
                "edges between triangles that face opposite sides");
  }
  return volume(surface) == 0 ? "a volume of 0" : "";
}

double volume(const Surface& surface) {
  if (surface.vertices.empty()) return 0;
  const Vector& from = surface.vertices[0];  // nearby, so little cancels
  double sum = 0;
  for (const auto& t : surface.triangles) {
    sum += dot(surface.vertices[t[0]] - from, cross(surface.vertices[t[1]] - from, surface.vertices[t[2]] - from));
  }
  return sum / 6;
}

Normals normals_of(const Surface& surface) {
  Normals normals;
  normals.triangle.resize(surface.triangles.size());
  normals.edge.resize(surface.triangles.size());
  normals.vertex.resize(surface.vertices.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const Vector corner[3] = {surface.vertices[a], surface.vertices[b], surface.vertices[c]};
    const Vector normal = unit_normal(corner[0], corner[1], corner[2]);
    normals.triangle[t] = normal;
    if (normal == Vector{}) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector ahead = unit(corner[(k + 1) % 3] - corner[k]);
      const Vector back = unit(corner[(k + 2) % 3] - corner[k]);
      Vector& vertex = normals.vertex[surface.triangles[t][k]];
      vertex = vertex + normal * angle_between(ahead, back);
    }
  }
  const std::vector<Side> sides = sides_of(surface);
  each_edge(sides, [&](std::size_t first, std::size_t last) {
    Vector sum{};
    for (std::size_t i = first; i < last; ++i) sum = sum + normals.triangle[sides[i].triangle];
    for (std::size_t i = first; i < last; ++i) normals.edge[sides[i].triangle][sides[i].corner] = sum;
  });
  return normals;
}

}  // namespace motes::meshes
