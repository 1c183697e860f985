// Pictures and meshes: immutable, named by a fingerprint of their content, so that recorded lists carry only the name.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <vector>

#include "base/bytes.h"

namespace motes::meshes {

/// See base/registry.h.
using AssetKey = std::uint64_t;

/// What a sprite of kind image shows: sRGB with straight alpha, 8 bits, red green blue alpha, rows from top to bottom.
/// Skies and solids show linear light instead.
struct Picture {
  std::int32_t width = 0;   // pixels
  std::int32_t height = 0;  // pixels
  std::vector<std::uint8_t> rgba;
  std::vector<float> light{};  // linear red green blue, in place of rgba

  bool operator==(const Picture&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Picture& picture) {
  visit(picture.width, picture.height, picture.rgba, picture.light);
}

/// Triangles with common vertices, visible from both sides.
struct Mesh {
  std::vector<float> vertices;           // m: x, y, z of each
  std::vector<std::uint32_t> triangles;  // three indices of vertices each
  std::vector<float> colors{};           // linear RGB of each vertex; empty: it has none
  std::vector<float> density{};          // of births at each vertex, relative to others; empty: even

  bool operator==(const Mesh&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Mesh& mesh) {
  visit(mesh.vertices, mesh.triangles, mesh.colors, mesh.density);
}

/// Linear RGB of a corner, 0..2, of a triangle of a mesh that has colours.
inline const float* color_of(const Mesh& mesh, std::size_t triangle, std::size_t corner) {
  return mesh.colors.data() + 3 * std::size_t{mesh.triangles[3 * triangle + corner]};
}

inline constexpr std::int32_t kMaxPicture = 8192;                      // pixels, each side
inline constexpr std::size_t kMaxTriangles = std::size_t{1} << 26;     // of one mesh

/// Throw std::invalid_argument, naming the argument, its value and what is allowed.
void check(const Picture& picture);
void check(const Mesh& mesh);

/// Checks the asset, keeps it until the process ends, and returns its key. Equal assets are kept once. Thread-safe, as
/// are all functions here. Throws std::invalid_argument where the asset is not valid.
AssetKey keep(Picture picture);
AssetKey keep(Mesh mesh);

/// The asset with that key. Throws std::invalid_argument where this process keeps no such picture or mesh.
std::shared_ptr<const Picture> picture(AssetKey key);
std::shared_ptr<const Mesh> mesh(AssetKey key);

bool has_picture(AssetKey key);
bool has_mesh(AssetKey key);

/// The content of kept assets as bytes, for files; each is written once. Throws std::invalid_argument for an unknown
/// key.
void write_assets(const std::set<AssetKey>& keys, base::Bytes& out);

/// Keeps the assets that write_assets() wrote. Throws std::runtime_error where the bytes are damaged or an asset in
/// them is not valid.
void read_assets(base::Reader& in);

}  // namespace motes::meshes
