#include "surfaces/skin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "surfaces/cube_cases.h"

namespace motes::surfaces {
namespace {

constexpr int kPadded = kBlock + 1;  // nodes of a block's cells along an axis
constexpr std::uint32_t kNoVertex = 0xffffffffu;

// A block's part of the surface. Vertices are those on the edges that begin at its nodes, then the centres of polygons.
struct Part {
  std::vector<std::uint32_t> on_edges;  // by node and axis: its vertex; empty: the surface does not cross the block
  std::vector<float> vertices;
  std::size_t edge_vertices = 0;
  std::vector<std::uint32_t> triangles;
  std::uint32_t first = 0;  // number of its first vertex
};

// Returns how far a lone particle is where the density is `sum`, in its reach.
double distance(std::uint32_t sum) {
  const double part = std::min(static_cast<double>(sum) / (kWeight * kFull), 1.0);
  if (!(part > 0)) return 1;
  double root = 1;  // Newton's iteration for the cube root, from above
  for (int i = 0; i < 60; ++i) {
    const double better = (2 * root + part / (root * root)) / 3;
    if (!(better < root)) break;
    root = better;
  }
  return std::sqrt(std::max(1 - root, 0.0));
}

// The densities at the corners of a block's cells.
class Corners {
 public:
  Corners(const Field& field, BlockKey key) {
    const auto place = place_of(key);
    for (int b = 0; b < 8; ++b) {
      const int x = b & 1, y = b >> 1 & 1, z = b >> 2;
      const NodeBlock* block = field.find(key_of(place[0] + x, place[1] + y, place[2] + z));
      if (block == nullptr) continue;
      for (int k = z * kBlock; k < (z == 0 ? kBlock : kPadded); ++k) {
        for (int j = y * kBlock; j < (y == 0 ? kBlock : kPadded); ++j) {
          const auto from = static_cast<std::size_t>(((k % kBlock) * kBlock + j % kBlock) * kBlock);
          std::copy_n(block->begin() + static_cast<std::ptrdiff_t>(from), x == 0 ? kBlock : 1,
                      &sums_[at(x * kBlock, j, k)]);
        }
      }
    }
  }

  static std::size_t at(int x, int y, int z) { return static_cast<std::size_t>((z * kPadded + y) * kPadded + x); }
  std::uint32_t sum(int x, int y, int z) const { return sums_[at(x, y, z)]; }
  bool inside(int x, int y, int z) const { return sum(x, y, z) >= kLevel; }
  unsigned case_of(int x, int y, int z) const {
    unsigned bits = 0;
    for (int c = 0; c < 8; ++c) bits |= inside(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)) ? 1u << c : 0u;
    return bits;
  }
  bool crossed() const {
    const bool first = sums_[0] >= kLevel;
    return std::any_of(sums_.begin(), sums_.end(), [first](std::uint32_t sum) { return (sum >= kLevel) != first; });
  }

 private:
  std::array<std::uint32_t, std::size_t{kPadded} * kPadded * kPadded> sums_{};
};

// Returns how far along an edge the surface crosses it. It keeps away from the ends, so no triangle vanishes.
double crossing(std::uint32_t a, std::uint32_t b) {
  constexpr double kAtLevel = 1 / kReach, kNear = 0.02;
  const double from = distance(a), to = distance(b);
  return std::clamp((kAtLevel - from) / (to - from), kNear, 1 - kNear);
}

template <class Work>
void each_cell(const Work& work) {
  for (int z = 0; z < kBlock; ++z)
    for (int y = 0; y < kBlock; ++y)
      for (int x = 0; x < kBlock; ++x) work(x, y, z);
}

// Sets the vertices on the edges that begin at the block's nodes, and makes room for those at centres of polygons.
void cross_edges(const Field& field, BlockKey key, Part& part) {
  const Corners corners(field, key);
  if (!corners.crossed()) return;
  part.on_edges.assign(3 * kNodes, kNoVertex);
  const auto place = place_of(key);
  std::size_t edge = 0;
  each_cell([&](int x, int y, int z) {
    const bool inside = corners.inside(x, y, z);
    for (int axis = 0; axis < 3; ++axis, ++edge) {
      const int to[3] = {x + (axis == 0 ? 1 : 0), y + (axis == 1 ? 1 : 0), z + (axis == 2 ? 1 : 0)};
      if (corners.inside(to[0], to[1], to[2]) == inside) continue;
      const double along = crossing(corners.sum(x, y, z), corners.sum(to[0], to[1], to[2]));
      part.on_edges[edge] = static_cast<std::uint32_t>(part.vertices.size() / 3);
      const int node[3] = {x, y, z};
      for (int c = 0; c < 3; ++c) {
        const double at = static_cast<double>(place[static_cast<std::size_t>(c)] * kBlock + node[c]);
        part.vertices.push_back(static_cast<float>((at + (c == axis ? along : 0)) * field.measure().cell));
      }
    }
  });
  part.edge_vertices = part.vertices.size() / 3;
  std::size_t centres = 0;  // room for the vertices at centres of polygons
  each_cell([&](int x, int y, int z) { centres += cube_cases()[corners.case_of(x, y, z)].polygons.size(); });
  part.vertices.resize(part.vertices.size() + 3 * centres);
}

// The parts of all blocks, in the order of their keys.
class Parts {
 public:
  explicit Parts(const Field& field) : field_(field), keys_(field.keys()), parts_(keys_.size()) {}

  Skin skin(threads::Pool& pool) {
    pool.run(keys_.size(), [&](std::size_t i, std::size_t) { cross_edges(field_, keys_[i], parts_[i]); });
    std::size_t vertices = 0, numbers = 0;
    for (Part& part : parts_) {
      part.first = static_cast<std::uint32_t>(vertices);
      vertices += part.vertices.size() / 3;
      if (vertices > std::numeric_limits<std::uint32_t>::max()) refuse_size(field_.measure());
    }
    pool.run(keys_.size(), [&](std::size_t i, std::size_t) { fill(i); });
    for (const Part& part : parts_) numbers += part.triangles.size();
    Skin skin;
    skin.vertices.reserve(3 * vertices);
    skin.triangles.reserve(numbers);
    for (Part& part : parts_) {
      skin.vertices.insert(skin.vertices.end(), part.vertices.begin(), part.vertices.end());
      skin.triangles.insert(skin.triangles.end(), part.triangles.begin(), part.triangles.end());
      part = {};
    }
    return skin;
  }

 private:
  const Part& part(BlockKey key) const {
    return parts_[static_cast<std::size_t>(std::lower_bound(keys_.begin(), keys_.end(), key) - keys_.begin())];
  }

  // Fills in the centres and the triangles of a block's cells.
  void fill(std::size_t i) {
    const Corners corners(field_, keys_[i]);
    if (!corners.crossed()) return;
    const auto place = place_of(keys_[i]);
    std::array<const Part*, 8> near{};  // the block and its neighbours, once needed
    near[0] = &parts_[i];
    Part& own = parts_[i];
    std::size_t centre = own.edge_vertices;
    each_cell([&](int x, int y, int z) {
      const CubeCase& found = cube_cases()[corners.case_of(x, y, z)];
      if (found.triangles.empty()) return;
      struct Vertex {
        const Part* of;
        std::uint32_t index;
      };
      const auto on_edge = [&](int edge) {
        const int low = corners_of_edge(edge)[0], axis = edge / 4;
        const int at[3] = {x + (low & 1), y + (low >> 1 & 1), z + (low >> 2)};
        int b = 0;
        for (int c = 0; c < 3; ++c) b |= at[c] / kBlock << c;
        const Part*& of = near[static_cast<std::size_t>(b)];
        if (of == nullptr) of = &part(key_of(place[0] + (b & 1), place[1] + (b >> 1 & 1), place[2] + (b >> 2)));
        const int node = (at[2] % kBlock * kBlock + at[1] % kBlock) * kBlock + at[0] % kBlock;
        return Vertex{of, of->on_edges[static_cast<std::size_t>(3 * node + axis)]};
      };
      const std::size_t first = centre;
      for (const auto& polygon : found.polygons) {
        double sums[3] = {};
        for (const std::uint8_t edge : polygon) {
          const Vertex v = on_edge(edge);
          for (std::size_t c = 0; c < 3; ++c) sums[c] += v.of->vertices[3 * v.index + c];
        }
        for (std::size_t c = 0; c < 3; ++c)
          own.vertices[3 * centre + c] = static_cast<float>(sums[c] / static_cast<double>(polygon.size()));
        ++centre;
      }
      for (const std::uint8_t corner : found.triangles) {
        if (corner >= kCentre) {
          own.triangles.push_back(own.first + static_cast<std::uint32_t>(first + corner - kCentre));
        } else {
          const Vertex v = on_edge(corner);
          own.triangles.push_back(v.of->first + v.index);
        }
      }
    });
  }

  const Field& field_;
  std::vector<BlockKey> keys_;
  std::vector<Part> parts_;
};

}  // namespace

Skin skin_of(const Field& field, threads::Pool& pool) { return Parts(field).skin(pool); }

}  // namespace motes::surfaces
