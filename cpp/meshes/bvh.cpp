#include "meshes/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <span>

#include "base/vectors.h"

namespace motes::meshes {
namespace {

constexpr std::uint32_t kLeaf = 2;  // triangles that are not worth another split
constexpr int kBins = 16;
constexpr int kBalancedDepth = kMaxBvhDepth - 28;  // from here on nodes are halved: 2^28 triangles fit below it

struct Hull {
  std::array<float, 3> low, high;

  Hull() { low.fill(std::numeric_limits<float>::max()), high.fill(std::numeric_limits<float>::lowest()); }
  void add(const float* point) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], point[i]);
      high[i] = std::max(high[i], point[i]);
    }
  }
  void add(const Hull& other) {
    add(other.low.data());
    add(other.high.data());
  }
  // Returns half of the surface area.
  double area() const {
    const double x = double{high[0]} - low[0], y = double{high[1]} - low[1], z = double{high[2]} - low[2];
    return x * y + y * z + z * x;
  }
};

struct Facet {
  Hull hull;
  std::array<float, 3> middle;
  std::uint32_t triangle;
};

// Builds the tree: splits nodes where a ray is expected to test the fewest triangles (surface area heuristic, in bins;
// Wald 2007).
class Builder {
 public:
  Builder(Bvh& tree, std::vector<Facet> facets) : tree_(tree), facets_(std::move(facets)) {
    tree_.nodes.resize(1);
    build(0, 0, static_cast<std::uint32_t>(facets_.size()), 0);
  }
  std::span<const Facet> facets() const { return facets_; }

 private:
  void build(std::uint32_t at, std::uint32_t first, std::uint32_t last, int depth) {
    Hull hull, middles;
    for (std::uint32_t i = first; i < last; ++i) {
      hull.add(facets_[i].hull);
      middles.add(facets_[i].middle.data());
    }
    BvhNode node{};
    std::copy(hull.low.begin(), hull.low.end(), node.low);
    std::copy(hull.high.begin(), hull.high.end(), node.high);
    node.first = first;
    node.count = last - first;
    if (node.count > kLeaf) {
      const std::uint32_t middle = split(first, last, middles, depth);
      node.first = static_cast<std::uint32_t>(tree_.nodes.size());
      node.count = 0;
      tree_.nodes.resize(tree_.nodes.size() + 2);
      build(node.first, first, middle, depth + 1);
      build(node.first + 1, middle, last, depth + 1);
    }
    tree_.nodes[at] = node;
  }

  // Divides the facets into two parts, neither of them empty, and returns where the second one starts.
  std::uint32_t split(std::uint32_t first, std::uint32_t last, const Hull& middles, int depth) {
    std::size_t axis = 0;
    for (std::size_t i = 1; i < 3; ++i) {
      if (middles.high[i] - middles.low[i] > middles.high[axis] - middles.low[axis]) axis = i;
    }
    const float low = middles.low[axis], extent = middles.high[axis] - low;
    const auto begin = facets_.begin();
    if (extent > 0 && depth < kBalancedDepth) {
      const auto bin_of = [&](const Facet& facet) {
        return std::min(kBins - 1, static_cast<int>((facet.middle[axis] - low) / extent * kBins));
      };
      const int bin = best_bin(first, last, bin_of);
      const auto middle =
          std::stable_partition(begin + first, begin + last, [&](const Facet& facet) { return bin_of(facet) < bin; });
      if (middle != begin + first && middle != begin + last) return static_cast<std::uint32_t>(middle - begin);
    }
    const std::uint32_t half = first + (last - first) / 2;
    std::sort(begin + first, begin + last, [&](const Facet& a, const Facet& b) {
      return a.middle[axis] != b.middle[axis] ? a.middle[axis] < b.middle[axis] : a.triangle < b.triangle;
    });
    return half;
  }

  // Returns the first bin of the second part.
  template <class BinOf>
  int best_bin(std::uint32_t first, std::uint32_t last, const BinOf& bin_of) const {
    std::array<Hull, kBins> hull;
    std::array<double, kBins> count{}, above{};
    for (std::uint32_t i = first; i < last; ++i) {
      const auto bin = static_cast<std::size_t>(bin_of(facets_[i]));
      hull[bin].add(facets_[i].hull);
      ++count[bin];
    }
    Hull part;
    double sum = 0;
    for (std::size_t bin = kBins - 1; bin > 0; --bin) {
      if (count[bin] != 0) part.add(hull[bin]);
      sum += count[bin];
      above[bin] = sum == 0 ? 0 : part.area() * sum;
    }
    part = {};
    sum = 0;
    int best = 1;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t bin = 1; bin < kBins; ++bin) {
      if (count[bin - 1] != 0) part.add(hull[bin - 1]);
      sum += count[bin - 1];
      const double cost = (sum == 0 ? 0 : part.area() * sum) + above[bin];
      if (cost < least) least = cost, best = static_cast<int>(bin);
    }
    return best;
  }

  Bvh& tree_;
  std::vector<Facet> facets_;
};

Vector corner_of(const BvhTriangle& t, std::size_t i) { return {t.corner[i][0], t.corner[i][1], t.corner[i][2]}; }

// Sets the unit normal; returns false if the triangle has no area.
bool set_normal(BvhTriangle& t) {
  const Vector normal = cross(corner_of(t, 1) - corner_of(t, 0), corner_of(t, 2) - corner_of(t, 0));
  const double size = length(normal);
  if (!(size > 0)) return false;
  for (std::size_t i = 0; i < 3; ++i) t.normal[i] = static_cast<float>(normal[i] / size);
  return true;
}

Ball ball_around(const Bvh& tree) {
  const BvhNode& root = tree.nodes[0];
  const Vector low{root.low[0], root.low[1], root.low[2]}, high{root.high[0], root.high[1], root.high[2]};
  return {(low + high) * 0.5, length(high - low) * (0.5 * (1 + 1e-6))};
}

}  // namespace

Bvh build_bvh(const Mesh& mesh) {
  std::vector<BvhTriangle> triangles;
  std::vector<Facet> facets;
  std::vector<std::uint32_t> number;  // in the mesh
  for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
    BvhTriangle triangle{};
    Facet facet;
    for (std::size_t c = 0; c < 3; ++c) {
      const float* vertex = mesh.vertices.data() + 3 * std::size_t{mesh.triangles[i + c]};
      std::copy(vertex, vertex + 3, triangle.corner[c]);
      facet.hull.add(vertex);
    }
    if (!set_normal(triangle)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      facet.middle[axis] = 0.5f * facet.hull.low[axis] + 0.5f * facet.hull.high[axis];
    }
    facet.triangle = static_cast<std::uint32_t>(triangles.size());
    triangles.push_back(triangle);
    number.push_back(static_cast<std::uint32_t>(i / 3));
    facets.push_back(facet);
  }
  Bvh tree;
  if (facets.empty()) return tree;
  const Builder builder(tree, std::move(facets));
  for (const Facet& facet : builder.facets()) {
    tree.triangles.push_back(triangles[facet.triangle]);
    tree.origin.push_back(number[facet.triangle]);
  }
  const auto to_corners = [&](const std::vector<float>& of_vertices, std::size_t numbers, std::vector<float>& to) {
    for (std::size_t i = 0; i < 3 * tree.origin.size() && !of_vertices.empty(); ++i) {
      const float* own = of_vertices.data() + numbers * mesh.triangles[3 * std::size_t{tree.origin[i / 3]} + i % 3];
      to.insert(to.end(), own, own + numbers);
    }
  };
  to_corners(mesh.colors, 3, tree.colors);
  to_corners(mesh.uv, 2, tree.uv);
  to_corners(mesh.normals, 3, tree.normals);
  tree.ball = ball_around(tree);
  return tree;
}

std::shared_ptr<const Bvh> bvh_of(AssetKey key) {
  static std::mutex mutex;
  static std::map<AssetKey, std::shared_ptr<const Bvh>> trees;
  const std::scoped_lock lock(mutex);
  auto& tree = trees[key];
  if (tree == nullptr) tree = std::make_shared<const Bvh>(build_bvh(*mesh(key)));
  return tree;
}

}  // namespace motes::meshes
