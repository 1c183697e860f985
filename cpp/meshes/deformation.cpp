#include "meshes/deformation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "meshes/assets.h"
#include "meshes/form.h"
#include "simd/float_mode.h"

namespace motes::meshes {
namespace {

constexpr int kCells = 24;  // of the lattice along its longest side

struct KeptDeformation {
  Deformation deformation;
  std::array<std::array<std::vector<float>, 3>, 2> planes;
};

std::array<double, 3> vertex(const Mesh& mesh, std::size_t index) {
  const float* v = mesh.vertices.data() + 3 * index;
  return {v[0], v[1], v[2]};
}

// Lays the lattice around both meshes.
void lay(const Mesh& before, const Mesh& now, Deformation& d) {
  std::array<double, 3> low{}, high{};
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const Mesh* mesh : {&before, &now}) {
    for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
      low[i % 3] = std::min(low[i % 3], double{mesh->vertices[i]});
      high[i % 3] = std::max(high[i % 3], double{mesh->vertices[i]});
    }
  }
  const double longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  d.cell = static_cast<float>(longest / kCells);
  for (std::size_t c = 0; c < 3; ++c) {
    d.first[c] = static_cast<float>(low[c]);
    d.nodes[c] = std::max(2, static_cast<std::int32_t>(std::ceil((high[c] - low[c]) / d.cell)) + 1);
  }
}

// A lattice of displacements while they are collected.
class Displacements {
 public:
  explicit Displacements(const Deformation& d) : d_(d), sum_(size()), weight_(size()) {}

  std::size_t size() const {
    return static_cast<std::size_t>(d_.nodes[0]) * static_cast<std::size_t>(d_.nodes[1]) *
           static_cast<std::size_t>(d_.nodes[2]);
  }

  // Adds a displacement to the eight nodes around a place, more to the nearer ones.
  void add(const std::array<double, 3>& place, const std::array<double, 3>& displacement) {
    std::array<std::int32_t, 3> at{};
    std::array<double, 3> part{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double x = (place[c] - d_.first[c]) / d_.cell;
      at[c] = std::clamp(static_cast<std::int32_t>(x), 0, d_.nodes[c] - 2);
      part[c] = std::clamp(x - at[c], 0.0, 1.0);
    }
    for (unsigned corner = 0; corner < 8; ++corner) {
      const unsigned x = corner & 1U, y = corner >> 1U & 1U, z = corner >> 2U;
      const double weight = (x ? part[0] : 1 - part[0]) * (y ? part[1] : 1 - part[1]) * (z ? part[2] : 1 - part[2]);
      const std::size_t node =
          index(at[0] + static_cast<int>(x), at[1] + static_cast<int>(y), at[2] + static_cast<int>(z));
      weight_[node] += weight;
      for (std::size_t c = 0; c < 3; ++c) sum_[node][c] += weight * displacement[c];
    }
  }

  // Gives nodes far from the vertices the mean of their neighbours, outwards from the nodes that have one.
  void spread() {
    for (std::size_t i = 0; i < size(); ++i) {
      for (double& one : sum_[i]) one = weight_[i] > 0 ? one / weight_[i] : 0;
    }
    std::vector<std::size_t> reached;
    for (bool more = true; more;) {
      reached.clear();
      for (std::int32_t z = 0; z < d_.nodes[2]; ++z)
        for (std::int32_t y = 0; y < d_.nodes[1]; ++y)
          for (std::int32_t x = 0; x < d_.nodes[0]; ++x) {
            if (weight_[index(x, y, z)] == 0 && average(x, y, z)) reached.push_back(index(x, y, z));
          }
      for (const std::size_t node : reached) weight_[node] = 1;
      more = !reached.empty();
    }
  }

  void write(std::array<std::vector<float>, 3>& planes) const {
    for (std::size_t c = 0; c < 3; ++c) {
      planes[c].resize(size());
      std::transform(sum_.begin(), sum_.end(), planes[c].begin(),
                     [c](const std::array<double, 3>& v) { return static_cast<float>(v[c]); });
    }
  }

 private:
  std::size_t index(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(d_.nodes[0]) *
               (static_cast<std::size_t>(y) + static_cast<std::size_t>(d_.nodes[1]) * static_cast<std::size_t>(z));
  }

  // Sets a node to the mean of those of its six neighbours that are known; returns whether there is one.
  bool average(std::int32_t x, std::int32_t y, std::int32_t z) {
    std::array<double, 3> sum{};
    double known = 0;
    const auto take = [&](std::int32_t i, std::int32_t j, std::int32_t k) {
      if (i < 0 || j < 0 || k < 0 || i >= d_.nodes[0] || j >= d_.nodes[1] || k >= d_.nodes[2]) return;
      const std::size_t node = index(i, j, k);
      if (weight_[node] == 0) return;
      known += 1;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += sum_[node][c];
    };
    for (const int step : {-1, 1}) {
      take(x + step, y, z);
      take(x, y + step, z);
      take(x, y, z + step);
    }
    if (known == 0) return false;
    for (std::size_t c = 0; c < 3; ++c) sum_[index(x, y, z)][c] = sum[c] / known;
    return true;
  }

  const Deformation& d_;
  std::vector<std::array<double, 3>> sum_;
  std::vector<double> weight_;
};

void collect(KeptDeformation& kept, const Mesh& before, const Mesh& now) {
  Deformation& d = kept.deformation;
  lay(before, now, d);
  double most = 0;
  Displacements at_start(d), at_end(d);
  for (std::size_t i = 0; i < before.vertices.size() / 3; ++i) {
    const std::array<double, 3> from = vertex(before, i), to = vertex(now, i);
    const std::array<double, 3> way{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    most = std::max(most, way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    at_start.add(from, way);
    at_end.add(to, way);
  }
  d.most = static_cast<float>(std::sqrt(most));
  at_start.spread();
  at_end.spread();
  at_start.write(kept.planes[0]);
  at_end.write(kept.planes[1]);
  for (std::size_t end = 0; end < 2; ++end) {
    for (std::size_t c = 0; c < 3; ++c) d.displacement[end][c] = kept.planes[end][c].data();
  }
}

}  // namespace

const Deformation* deformation_of(const MeshForm& before, const MeshForm& now) {
  static std::mutex mutex;
  static std::map<std::pair<const MeshForm*, const MeshForm*>, std::unique_ptr<KeptDeformation>> all;
  const std::scoped_lock held(mutex);
  std::unique_ptr<KeptDeformation>& kept = all[{&before, &now}];
  if (kept != nullptr) return &kept->deformation;
  need_inside(before);
  need_inside(now);
  const std::shared_ptr<const Mesh> first = mesh_of(before), second = mesh_of(now);
  if (first->triangles != second->triangles || first->vertices.size() != second->vertices.size()) {
    throw std::invalid_argument("Mesh: a mesh deforms only into one with the same triangles");
  }
  const simd::FloatMode mode;
  auto made = std::make_unique<KeptDeformation>();
  made->deformation.before = &before;
  made->deformation.now = &now;
  collect(*made, *first, *second);
  kept = std::move(made);
  return &kept->deformation;
}

}  // namespace motes::meshes
