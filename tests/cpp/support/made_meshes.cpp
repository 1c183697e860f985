#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "support/made_meshes.h"

using motes::meshes::Mesh;

namespace test {
namespace {

constexpr double kPi = 3.14159265358979323846;
using Vector = std::array<double, 3>;

Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vector& a) { return std::sqrt(dot(a, a)); }

void add(Mesh& mesh, double x, double y, double z) {
  for (const double v : {x, y, z}) mesh.vertices.push_back(static_cast<float>(v));
}

// Adds two triangles for each cell of a grid of vertices, `columns` in each row.
void add_grid(Mesh& mesh, std::uint32_t rows, std::uint32_t columns) {
  for (std::uint32_t i = 0; i + 1 < rows; ++i) {
    for (std::uint32_t j = 0; j + 1 < columns; ++j) {
      const std::uint32_t a = i * columns + j, b = a + columns, c = b + 1, d = a + 1;
      mesh.triangles.insert(mesh.triangles.end(), {a, c, b, a, d, c});
    }
  }
}

double to_segment(const Vector& p, const Vector& a, const Vector& b) {
  const Vector ab = minus(b, a);
  const double part = std::clamp(dot(minus(p, a), ab) / std::max(dot(ab, ab), 1e-300), 0.0, 1.0);
  return length(minus(p, {a[0] + ab[0] * part, a[1] + ab[1] * part, a[2] + ab[2] * part}));
}

double to_triangle(const Vector& p, const Vector& a, const Vector& b, const Vector& c) {
  const Vector normal = cross(minus(b, a), minus(c, a));
  const double size = length(normal);
  const bool above = size > 0 && dot(cross(minus(b, a), minus(p, a)), normal) >= 0 &&
                     dot(cross(minus(c, b), minus(p, b)), normal) >= 0 &&
                     dot(cross(minus(a, c), minus(p, c)), normal) >= 0;
  if (above) return std::fabs(dot(minus(p, a), normal)) / size;
  return std::min({to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a)});
}

// Returns the solid angle of a triangle (A. van Oosterom and J. Strackee, 1983).
double solid_angle(Vector a, Vector b, Vector c) {
  const double x = length(a), y = length(b), z = length(c);
  return 2 * std::atan2(dot(a, cross(b, c)), x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
}

}  // namespace

Mesh globe(int parallels, int meridians, double radius) {
  Mesh mesh;
  for (int i = 0; i <= parallels; ++i) {
    for (int j = 0; j <= meridians; ++j) {
      const double down = kPi * i / parallels, turn = 2 * kPi * j / meridians;
      add(mesh, radius * std::sin(down) * std::cos(turn), radius * std::cos(down),
          radius * std::sin(down) * std::sin(turn));
    }
  }
  add_grid(mesh, static_cast<std::uint32_t>(parallels + 1), static_cast<std::uint32_t>(meridians + 1));
  return mesh;
}

Mesh torus(int around, int across, double radius, double tube) {
  Mesh mesh;
  for (int i = 0; i <= around; ++i) {
    for (int j = 0; j <= across; ++j) {
      const double turn = 2 * kPi * i / around, roll = 2 * kPi * j / across;
      const double r = radius + tube * std::cos(roll);
      add(mesh, r * std::cos(turn), tube * std::sin(roll), r * std::sin(turn));
    }
  }
  add_grid(mesh, static_cast<std::uint32_t>(around + 1), static_cast<std::uint32_t>(across + 1));
  return mesh;
}

Mesh block(double low, double high, bool inwards) {
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    add(mesh, (corner & 1) != 0 ? high : low, (corner & 2) != 0 ? high : low, (corner & 4) != 0 ? high : low);
  }
  mesh.triangles = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                    2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  for (std::size_t i = 0; inwards && i < mesh.triangles.size(); i += 3) {
    std::swap(mesh.triangles[i], mesh.triangles[i + 1]);
  }
  return mesh;
}

Mesh tetrahedron() { return {{0, 0, 0, 1, 1, 0, 1, 0, 1, 0, 1, 1}, {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2}}; }

Mesh together(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  const auto first = static_cast<std::uint32_t>(a.vertices.size() / 3);
  both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const std::uint32_t vertex : b.triangles) both.triangles.push_back(first + vertex);
  return both;
}

double distance_by_trying(const Mesh& mesh, double x, double y, double z) {
  const Vector p{x, y, z};
  const auto corner = [&](std::size_t i) {
    const float* v = mesh.vertices.data() + 3 * std::size_t{mesh.triangles[i]};
    return Vector{v[0], v[1], v[2]};
  };
  double least = std::numeric_limits<double>::infinity(), seen = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const Vector a = corner(i), b = corner(i + 1), c = corner(i + 2);
    least = std::min(least, to_triangle(p, a, b, c));
    seen += solid_angle(minus(a, p), minus(b, p), minus(c, p));
  }
  return std::fabs(seen) > 2 * kPi ? -least : least;
}

}  // namespace test
