#include "meshes/assets.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "base/checks.h"
#include "base/registry.h"
#include "base/sha256.h"

namespace motes::meshes {
namespace {

void check_side(const char* argument, std::int32_t pixels) {
  if (pixels < 1 || pixels > kMaxPicture) {
    base::refuse(argument, "1.." + std::to_string(kMaxPicture), std::to_string(pixels));
  }
}

// Returns a permanent key, from SHA-256: scripts may keep the keys of pictures and meshes beyond a run. The last
// `kLater` fields, which were added later, do not count if they are empty, that is, eight zero bytes each.
template <int kLater>
AssetKey lasting(const char* kind, std::span<const std::byte> bytes) {
  constexpr std::size_t kEmpty = sizeof(std::uint64_t);
  const auto is_zero = [](std::byte one) { return one == std::byte{}; };
  for (int i = 0; i < kLater && bytes.size() > kEmpty; ++i) {
    if (!std::all_of(bytes.end() - kEmpty, bytes.end(), is_zero)) break;
    bytes = bytes.first(bytes.size() - kEmpty);
  }
  base::Sha256 hash;
  hash.add(kind);
  hash.add(bytes);
  return std::stoull(hash.finish().substr(0, 16), nullptr, 16);
}

base::Registry<Picture>& pictures() {
  static base::Registry<Picture> all("picture", lasting<1>);
  return all;
}
base::Registry<Mesh>& meshes() {
  static base::Registry<Mesh> all("mesh", lasting<4>);
  return all;
}

void check_density(const Mesh& mesh) {
  const std::vector<float>& density = mesh.density;
  if (density.empty()) return;
  if (3 * density.size() != mesh.vertices.size()) {
    base::refuse("density", "a number for each vertex", std::to_string(density.size()) + " numbers");
  }
  for (const float x : density) {
    if (!(x >= 0 && x <= base::kFarthest)) base::refuse("density", "numbers, 0 or more", std::to_string(x));
  }
  if (*std::max_element(density.begin(), density.end()) == 0)
    base::refuse("density", "above 0 somewhere", "0 everywhere");
}

}  // namespace

void check(const Picture& picture) {
  check_side("width", picture.width);
  check_side("height", picture.height);
  if (!picture.light.empty()) {
    const std::size_t numbers = 3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    if (picture.light.size() != numbers || !picture.rgba.empty()) {
      base::refuse("light", "height * width * 3 = " + std::to_string(numbers) + " numbers",
                   std::to_string(picture.light.size()));
    }
    for (const float x : picture.light) {
      if (!(x >= 0 && x <= base::kFarthest)) base::refuse("light", "finite and not negative", std::to_string(x));
    }
    return;
  }
  const std::size_t bytes = 4 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  if (picture.rgba.size() != bytes) {
    base::refuse("rgba", "height * width * 4 = " + std::to_string(bytes) + " bytes",
                 std::to_string(picture.rgba.size()) + " bytes");
  }
}

void check(const Mesh& mesh) {
  if (mesh.vertices.empty() || mesh.vertices.size() % 3 != 0) {
    base::refuse("vertices", "three numbers for each of one or more vertices",
                 std::to_string(mesh.vertices.size()) + " numbers");
  }
  if (mesh.triangles.empty() || mesh.triangles.size() % 3 != 0) {
    base::refuse("triangles", "three indices for each of one or more triangles",
                 std::to_string(mesh.triangles.size()) + " indices");
  }
  if (mesh.triangles.size() / 3 > kMaxTriangles) {
    base::refuse("triangles", "at most " + std::to_string(kMaxTriangles) + " triangles",
                 std::to_string(mesh.triangles.size() / 3));
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const float x = mesh.vertices[i];
    if (!(x >= -base::kFarthest && x <= base::kFarthest)) {
      base::refuse("vertices[" + std::to_string(i / 3) + "]", "finite and within 1e15", std::to_string(x));
    }
  }
  if (!mesh.colors.empty() && mesh.colors.size() != mesh.vertices.size()) {
    base::refuse("colors", "three numbers for each vertex", std::to_string(mesh.colors.size()) + " numbers");
  }
  for (const float x : mesh.colors) {
    if (!(x >= 0 && x <= base::kFarthest)) base::refuse("colors", "linear RGB, 0 or more", std::to_string(x));
  }
  check_density(mesh);
  if (!mesh.uv.empty() && mesh.uv.size() / 2 * 3 != mesh.vertices.size()) {
    base::refuse("uv", "two numbers for each vertex", std::to_string(mesh.uv.size()) + " numbers");
  }
  for (const float x : mesh.uv) {
    if (!(x >= -1e6f && x <= 1e6f)) base::refuse("uv", "finite and within 1e6", std::to_string(x));
  }
  if (!mesh.normals.empty() && mesh.normals.size() != mesh.vertices.size()) {
    base::refuse("normals", "three numbers for each vertex", std::to_string(mesh.normals.size()) + " numbers");
  }
  for (const float x : mesh.normals) {
    if (!(x >= -1e6f && x <= 1e6f)) base::refuse("normals", "finite and within 1e6", std::to_string(x));
  }
  const std::size_t count = mesh.vertices.size() / 3;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangles[i] >= count) {
      base::refuse("triangles[" + std::to_string(i / 3) + "]", "indices of vertices, 0.." + std::to_string(count - 1),
                   std::to_string(mesh.triangles[i]));
    }
  }
}

AssetKey keep(Picture picture) { return pictures().keep(std::move(picture)); }
AssetKey keep(Mesh mesh) { return meshes().keep(std::move(mesh)); }

std::shared_ptr<const Picture> picture(AssetKey key) { return pictures().get(key); }
std::shared_ptr<const Mesh> mesh(AssetKey key) { return meshes().get(key); }

bool has_picture(AssetKey key) { return pictures().find(key) != nullptr; }
bool has_mesh(AssetKey key) { return meshes().find(key) != nullptr; }

void write_assets(const std::set<AssetKey>& keys, base::Bytes& out) {
  std::set<AssetKey> of_pictures, of_meshes;
  for (const AssetKey key : keys) (has_picture(key) ? of_pictures : of_meshes).insert(key);
  pictures().write(of_pictures, out);
  meshes().write(of_meshes, out);
}

void read_assets(base::Reader& in) {
  pictures().read(in);
  meshes().read(in);
}

}  // namespace motes::meshes
