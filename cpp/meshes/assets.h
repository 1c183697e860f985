// Pictures and meshes: immutable, named by a fingerprint of their content, so recorded lists carry only the name.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <vector>

#include "base/bytes.h"

namespace motes::meshes {

/// See base/registry.h.
using AssetKey = std::uint64_t;

/// The picture of a sprite of kind image: sRGB with straight alpha, 8 bits, red green blue alpha, rows from top to
/// bottom. Pictures of skies and solids hold linear light instead.
struct Picture {
  std::int32_t width = 0;   // pixels
  std::int32_t height = 0;  // pixels
  std::vector<std::uint8_t> rgba;
  std::vector<float> light{};  // linear red green blue, instead of rgba

  bool operator==(const Picture&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Picture& picture) {
  visit(picture.width, picture.height, picture.rgba, picture.light);
}

/// Triangles with shared vertices, visible from both sides.
struct Mesh {
  std::vector<float> vertices;           // m: x, y, z of each
  std::vector<std::uint32_t> triangles;  // three indices of vertices each
  std::vector<float> colors{};           // linear RGB of each vertex; empty: no colours
  std::vector<float> density{};          // relative density of births at each vertex; empty: uniform
  std::vector<float> uv{};  // place of each vertex on a picture, right and up, 0..1; it repeats beyond. Empty: none
  std::vector<float> normals{};  // of each vertex, of any length; empty: those of the triangles

  bool operator==(const Mesh&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Mesh& mesh) {
  visit(mesh.vertices, mesh.triangles, mesh.colors, mesh.density, mesh.uv, mesh.normals);
}

inline constexpr std::int32_t kMaxPicture = 8192;                      // pixels, each side
inline constexpr std::size_t kMaxTriangles = std::size_t{1} << 26;     // of one mesh

/// Throw std::invalid_argument, naming the argument, its value and what is allowed.
void check(const Picture& picture);
void check(const Mesh& mesh);

/// Checks the asset, keeps it until the process ends, and returns its key. Equal assets are kept once. Thread-safe, as
/// are all functions here. Throws std::invalid_argument if the asset is not valid.
AssetKey keep(Picture picture);
AssetKey keep(Mesh mesh);

/// Return the asset with this key. Throw std::invalid_argument if this process keeps no such picture or mesh.
std::shared_ptr<const Picture> picture(AssetKey key);
std::shared_ptr<const Mesh> mesh(AssetKey key);

bool has_picture(AssetKey key);
bool has_mesh(AssetKey key);

/// Writes the content of kept assets, each once, for files. Throws std::invalid_argument for an unknown key.
void write_assets(const std::set<AssetKey>& keys, base::Bytes& out);

/// Keeps the assets that write_assets() wrote. Throws std::runtime_error if the bytes are damaged or an asset in them
/// is not valid.
void read_assets(base::Reader& in);

}  // namespace motes::meshes
