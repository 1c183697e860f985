#include "meshes/assets.h"

#include <cstdio>
#include <map>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>

#include "base/checks.h"
#include "base/fields.h"
#include "base/sha256.h"

namespace motes::meshes {
namespace {

std::string text(AssetKey key) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(key));
  return digits;
}

void check_side(const char* argument, std::int32_t pixels) {
  if (pixels < 1 || pixels > kMaxPicture) {
    base::refuse(argument, "1.." + std::to_string(kMaxPicture), std::to_string(pixels));
  }
}

// The kind belongs to the content: a picture never has the key of a mesh.
template <class T>
AssetKey fingerprint(const T& asset, const char* kind) {
  base::Bytes bytes;
  base::write_fields(asset, bytes);
  base::Sha256 hash;
  hash.add(kind);
  hash.add(bytes.view());
  const AssetKey key = std::stoull(hash.finish().substr(0, 16), nullptr, 16);
  return key == 0 ? 1 : key;
}

// All assets of one kind in this process.
template <class T>
class Registry {
 public:
  explicit Registry(const char* kind) : kind_(kind) {}

  AssetKey keep(T asset) {
    const AssetKey key = fingerprint(asset, kind_);
    const std::scoped_lock lock(mutex_);
    auto& kept = all_[key];
    if (kept == nullptr) {
      kept = std::make_shared<const T>(std::move(asset));
    } else if (!(*kept == asset)) {
      throw std::runtime_error(std::string("two different assets have the key ") + text(key) + ": change one of them");
    }
    return key;
  }

  std::shared_ptr<const T> find(AssetKey key) {
    const std::scoped_lock lock(mutex_);
    const auto found = all_.find(key);
    return found == all_.end() ? nullptr : found->second;
  }

  std::shared_ptr<const T> get(AssetKey key) {
    auto found = find(key);
    if (found == nullptr) throw std::invalid_argument(std::string("no ") + kind_ + " has the key " + text(key));
    return found;
  }

 private:
  const char* kind_;
  std::mutex mutex_;
  std::map<AssetKey, std::shared_ptr<const T>> all_;
};

Registry<Picture>& pictures() {
  static Registry<Picture> all("picture");
  return all;
}
Registry<Mesh>& meshes() {
  static Registry<Mesh> all("mesh");
  return all;
}

// What a file holds.
struct Assets {
  std::vector<Picture> pictures;
  std::vector<Mesh> meshes;
};

template <class Visitor>
void fields(Visitor& visit, Assets& assets) {
  visit(assets.pictures, assets.meshes);
}

}  // namespace

void check(const Picture& picture) {
  check_side("width", picture.width);
  check_side("height", picture.height);
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
  const std::size_t count = mesh.vertices.size() / 3;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangles[i] >= count) {
      base::refuse("triangles[" + std::to_string(i / 3) + "]", "indices of vertices, 0.." + std::to_string(count - 1),
                   std::to_string(mesh.triangles[i]));
    }
  }
}

AssetKey keep(Picture picture) {
  check(picture);
  return pictures().keep(std::move(picture));
}
AssetKey keep(Mesh mesh) {
  check(mesh);
  return meshes().keep(std::move(mesh));
}

std::shared_ptr<const Picture> picture(AssetKey key) { return pictures().get(key); }
std::shared_ptr<const Mesh> mesh(AssetKey key) { return meshes().get(key); }

bool has_picture(AssetKey key) { return pictures().find(key) != nullptr; }
bool has_mesh(AssetKey key) { return meshes().find(key) != nullptr; }

void write_assets(const std::set<AssetKey>& keys, base::Bytes& out) {
  Assets assets;
  for (const AssetKey key : keys) {
    if (const auto found = pictures().find(key)) {
      assets.pictures.push_back(*found);
    } else {
      assets.meshes.push_back(*mesh(key));
    }
  }
  base::write_fields(assets, out);
}

void read_assets(base::Reader& in) {
  Assets assets;
  base::read_fields(in, assets);
  try {
    for (Picture& picture : assets.pictures) keep(std::move(picture));
    for (Mesh& mesh : assets.meshes) keep(std::move(mesh));
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(std::string("damaged bytes: ") + error.what());
  }
}

}  // namespace motes::meshes
