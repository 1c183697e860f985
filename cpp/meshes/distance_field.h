// The signed distance to a closed surface, at the nodes of a regular grid around it.
//
// It is exact within kBand cells of the surface, where its sign and slope matter. Elsewhere it comes from fast sweeping
// (H. Zhao, 2005) and tells how far a particle may fly without meeting the surface. The bits are the same for any
// number of threads.
#pragma once

#include <array>
#include <vector>

#include "meshes/surface.h"
#include "threads/pool.h"

namespace motes::meshes {

inline constexpr int kLeastResolution = 8, kMostResolution = 512;  // cells along the longest side of the mesh
inline constexpr int kMargin = 2;  // cells around the mesh
inline constexpr int kBand = 3;  // cells

struct DistanceField {
  std::array<std::int32_t, 3> nodes{};  // along x, y, z; x varies fastest
  std::array<float, 3> low{};  // position of the first node, m
  float cell = 0;  // side of a cell, m
  std::vector<float> distance;  // m, negative inside

  std::size_t at(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(nodes[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(nodes[0]) +
           static_cast<std::size_t>(x);
  }
  Vector place(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return {low[0] + double{cell} * x, low[1] + double{cell} * y, low[2] + double{cell} * z};
  }
};

/// Returns the distance field of a closed surface. If its triangles face inwards, they are taken to face outwards.
DistanceField distance_grid(const Surface& surface, int resolution, threads::Pool& pool);

/// Returns the cells with a corner inside, as the numbers of their first nodes, ascending.
std::vector<std::uint32_t> inner_cells(const DistanceField& grid);

}  // namespace motes::meshes
