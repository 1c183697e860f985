#include "meshes/distance_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/vectors.h"
#include "meshes/nearest.h"

namespace motes::meshes {
namespace {

// NOLINTBEGIN(misc-unused-using-decls): it does not see that operators are used
// NOLINTEND(misc-unused-using-decls)

constexpr float kUnknown = std::numeric_limits<float>::max();
constexpr int kMostRounds = 8;  // of eight sweeps each: only labyrinths take more than one
constexpr std::size_t kRange = 4096;  // nodes per work item

using Node = std::array<std::int32_t, 3>;

DistanceField empty_grid(const Surface& surface, int resolution) {
  Vector low{}, high{};
  low.fill(std::numeric_limits<double>::max());
  high.fill(std::numeric_limits<double>::lowest());
  for (const auto& triangle : surface.triangles) {
    for (const std::uint32_t vertex : triangle) {
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], surface.vertices[vertex][i]);
        high[i] = std::max(high[i], surface.vertices[vertex][i]);
      }
    }
  }
  const double longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  DistanceField grid;
  grid.cell = static_cast<float>(longest / resolution);
  std::size_t count = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto cells = static_cast<std::int32_t>(std::ceil((high[i] - low[i]) / grid.cell));
    grid.nodes[i] = std::max(cells, 1) + 2 * kMargin + 1;
    const double spare = (cells * double{grid.cell} - (high[i] - low[i])) / 2;
    grid.low[i] = static_cast<float>(low[i] - spare - kMargin * double{grid.cell});
    count *= static_cast<std::size_t>(grid.nodes[i]);
  }
  grid.distance.assign(count, kUnknown);
  return grid;
}

// Calls use(x, y, z) for the nodes in a box around the triangle that are near its plane.
template <class Use>
void each_near(const DistanceField& grid, const Vector& a, const Vector& b, const Vector& c, const Use& use) {
  const double band = kBand * double{grid.cell};
  Node first{}, last{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double low = std::min({a[i], b[i], c[i]}) - band - grid.low[i];
    const double high = std::max({a[i], b[i], c[i]}) + band - grid.low[i];
    first[i] = std::max(0, static_cast<std::int32_t>(std::ceil(low / grid.cell)));
    last[i] = std::min(grid.nodes[i] - 1, static_cast<std::int32_t>(std::floor(high / grid.cell)));
  }
  const Vector normal = cross(b - a, c - a);
  const double far = band * length(normal);
  for (std::int32_t z = first[2]; z <= last[2]; ++z) {
    for (std::int32_t y = first[1]; y <= last[1]; ++y) {
      for (std::int32_t x = first[0]; x <= last[0]; ++x) {
        if (std::fabs(dot(grid.place(x, y, z) - a, normal)) <= far) use(x, y, z);
      }
    }
  }
}

// Returns the numbers of the nodes that may be within the band.
std::vector<std::uint32_t> band_of(const DistanceField& grid, const Surface& surface) {
  std::vector<std::uint8_t> near(grid.distance.size());
  for (const auto& [a, b, c] : surface.triangles) {
    each_near(grid, surface.vertices[a], surface.vertices[b], surface.vertices[c],
              [&](std::int32_t x, std::int32_t y, std::int32_t z) { near[grid.at(x, y, z)] = 1; });
  }
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t i = 0; i < near.size(); ++i) {
    if (near[i] != 0) nodes.push_back(i);
  }
  return nodes;
}

void fill_band(DistanceField& grid, const Surface& surface, threads::Pool& pool) {
  const SignedDistance nearest(surface, volume(surface) < 0 ? -1 : 1);
  const std::vector<std::uint32_t> nodes = band_of(grid, surface);
  const double limit = kBand * double{grid.cell};
  threads::over_ranges(pool, nodes.size(), kRange, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const auto row = static_cast<std::uint32_t>(grid.nodes[0]), column = static_cast<std::uint32_t>(grid.nodes[1]);
      const auto x = static_cast<std::int32_t>(nodes[i] % row);
      const auto y = static_cast<std::int32_t>(nodes[i] / row % column);
      const auto z = static_cast<std::int32_t>(nodes[i] / row / column);
      const double found = nearest.distance(grid.place(x, y, z), limit);
      if (std::fabs(found) < limit) grid.distance[nodes[i]] = static_cast<float>(found);
    }
  });
}

// Solves |gradient| = 1 for a node. `u`: the smallest distance of a neighbour along each axis, not negative.
double upwind(std::array<double, 3> u, double cell) {
  std::sort(u.begin(), u.end());
  double found = u[0] + cell;
  if (found <= u[1]) return found;
  found = 0.5 * (u[0] + u[1] + std::sqrt(std::max(2 * cell * cell - (u[0] - u[1]) * (u[0] - u[1]), 0.0)));
  if (found <= u[2]) return found;
  const double sum = u[0] + u[1] + u[2];
  const double squares = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
  return (sum + std::sqrt(std::max(sum * sum - 3 * (squares - cell * cell), 0.0))) / 3;
}

class Sweeper {
 public:
  explicit Sweeper(DistanceField& grid) : grid_(grid), known_(grid.distance.size()) {
    for (std::size_t i = 0; i < known_.size(); ++i) known_[i] = grid.distance[i] != kUnknown;
    step_ = {1, grid.nodes[0], std::ptrdiff_t{grid.nodes[0]} * grid.nodes[1]};
  }

  void run() {
    for (int round = 0; round < kMostRounds; ++round) {
      bool changed = false;
      for (int order = 0; order < 8; ++order) changed |= sweep((order & 1) != 0, (order & 2) != 0, (order & 4) != 0);
      if (!changed) return;
    }
  }

 private:
  bool sweep(bool back_x, bool back_y, bool back_z) {
    bool changed = false;
    const auto [nx, ny, nz] = grid_.nodes;
    for (std::int32_t k = 0; k < nz; ++k) {
      const std::int32_t z = back_z ? nz - 1 - k : k;
      for (std::int32_t j = 0; j < ny; ++j) {
        const std::int32_t y = back_y ? ny - 1 - j : j;
        const std::size_t row = grid_.at(0, y, z);
        for (std::int32_t i = 0; i < nx; ++i) {
          const std::int32_t x = back_x ? nx - 1 - i : i;
          if (!known_[row + static_cast<std::size_t>(x)])
            changed |= update({x, y, z}, row + static_cast<std::size_t>(x));
        }
      }
    }
    return changed;
  }

  bool update(const Node& node, std::size_t at) {
    std::array<double, 3> nearest{};
    float least = kUnknown;  // with its sign
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float* here = grid_.distance.data() + at;
      const float below = node[axis] > 0 ? here[-step_[axis]] : kUnknown;
      const float above = node[axis] < grid_.nodes[axis] - 1 ? here[step_[axis]] : kUnknown;
      const float near = std::fabs(below) <= std::fabs(above) ? below : above;
      nearest[axis] = std::fabs(near);
      if (std::fabs(near) < std::fabs(least)) least = near;
    }
    if (least == kUnknown) return false;
    const auto found = static_cast<float>(upwind(nearest, grid_.cell));
    if (!(found < std::fabs(grid_.distance[at]))) return false;
    // Improvements below a hundredth of a cell are not worth another round.
    const bool worth = std::fabs(grid_.distance[at]) - found > 0.01f * grid_.cell;
    grid_.distance[at] = std::copysign(found, least);
    return worth;
  }

  DistanceField& grid_;
  std::vector<std::uint8_t> known_;
  std::array<std::ptrdiff_t, 3> step_{};
};

}  // namespace

DistanceField distance_grid(const Surface& surface, int resolution, threads::Pool& pool) {
  DistanceField grid = empty_grid(surface, resolution);
  fill_band(grid, surface, pool);
  Sweeper(grid).run();
  return grid;
}

std::vector<std::uint32_t> inner_cells(const DistanceField& grid) {
  std::vector<std::uint32_t> cells;
  for (std::int32_t z = 0; z + 1 < grid.nodes[2]; ++z) {
    for (std::int32_t y = 0; y + 1 < grid.nodes[1]; ++y) {
      for (std::int32_t x = 0; x + 1 < grid.nodes[0]; ++x) {
        bool inner = false;
        for (int corner = 0; corner < 8 && !inner; ++corner) {
          inner = grid.distance[grid.at(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2))] <= 0;
        }
        if (inner) cells.push_back(static_cast<std::uint32_t>(grid.at(x, y, z)));
      }
    }
  }
  return cells;
}

}  // namespace motes::meshes
