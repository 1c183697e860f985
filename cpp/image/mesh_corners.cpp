#include "image/mesh_corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>

#include "meshes/surface.h"

namespace motes::image {
namespace {

constexpr std::size_t kWhole = 16;  // lanes of the widest vector

void put(const std::array<Vector, 4>& rows, std::size_t at, MeshCorners& to) {
  const auto room = static_cast<std::size_t>(to.room);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to.planes[(3 * row + axis) * room + at] = static_cast<float>(rows[row][axis]);
    }
  }
}

// Returns planes of `numbers` values per corner, of those of the mesh's vertices. `inwards`: the triangles face inwards
// and have been turned around.
std::vector<float> planes_of(const std::vector<float>& values, std::size_t numbers, const meshes::Mesh& mesh,
                             const meshes::Surface& surface, bool inwards, std::size_t room) {
  if (values.empty()) return {};
  std::vector<float> planes(3 * numbers * room);
  for (std::size_t i = 0; i < surface.origin.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t turned = inwards ? (3 - k) % 3 : k;
      const float* own = values.data() + numbers * mesh.triangles[3 * std::size_t{surface.origin[i]} + turned];
      for (std::size_t c = 0; c < numbers; ++c) planes[(numbers * k + c) * room + i] = own[c];
    }
  }
  return planes;
}

MeshCorners corners_of(const meshes::Mesh& mesh) {
  const meshes::Surface surface = meshes::weld(mesh);
  MeshCorners made;
  const std::size_t count = surface.triangles.size();
  made.triangles = static_cast<int>(count);
  made.room = static_cast<int>((count + kWhole - 1) / kWhole * kWhole);
  made.closed = count != 0 && meshes::opening(surface).empty();
  const bool inwards = made.closed && meshes::volume(surface) < 0;
  made.planes.assign(12 * static_cast<std::size_t>(made.room), 0.0f);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<Vector, 4> rows;
    for (std::size_t k = 0; k < 3; ++k) rows[k] = surface.vertices[surface.triangles[i][k]];
    if (inwards) std::swap(rows[1], rows[2]);
    const Vector across = cross(rows[1] - rows[0], rows[2] - rows[0]);
    const double square = dot(across, across);
    rows[3] = square > 0 ? across * (1 / std::sqrt(square)) : Vector{};
    put(rows, i, made);
  }
  const auto planes = [&](const std::vector<float>& values, std::size_t numbers) {
    return planes_of(values, numbers, mesh, surface, inwards, static_cast<std::size_t>(made.room));
  };
  made.colors = planes(mesh.colors, 3);
  for (float& color : made.colors) color = std::min(color, 1.0f);
  made.normals = planes(mesh.normals, 3);
  made.uv = planes(mesh.uv, 2);
  return made;
}

}  // namespace

const MeshCorners& mesh_corners(meshes::AssetKey key) {
  static std::mutex mutex;
  static std::map<meshes::AssetKey, std::unique_ptr<const MeshCorners>> all;
  const std::scoped_lock lock(mutex);
  auto& corners = all[key];
  if (corners == nullptr) corners = std::make_unique<const MeshCorners>(corners_of(*meshes::mesh(key)));
  return *corners;
}

float reach_of_mesh(meshes::AssetKey key) {
  const std::vector<float>& v = meshes::mesh(key)->vertices;
  double most = 0;
  for (std::size_t i = 0; i + 2 < v.size(); i += 3) {
    most = std::max(most, double{v[i]} * v[i] + double{v[i + 1]} * v[i + 1] + double{v[i + 2]} * v[i + 2]);
  }
  return static_cast<float>(std::sqrt(most) * 1.000001);
}

}  // namespace motes::image
