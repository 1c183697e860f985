// What it costs to bounce off a mesh, and to make its signed distance field.
#pragma once

#include <cstddef>

namespace motes::bench {

/// On one core. A ball of some 10,000 triangles with a grid of 96 cells along each axis; times are the least of the
/// repeats, nanoseconds per particle and step of `bounce` alone. Particles move 2 cells per step.
struct MeshBench {
  std::size_t triangles = 0;
  std::size_t grid_bytes = 0;
  double build_s = 0;   // processor time on one thread
  double spread = 0;    // all over the mesh's box, inside and outside
  double near = 0;      // all within 5 % of the radius from the surface
  double away = 0;      // all beyond the box
  double ball = 0;      // spread, but off a shapes::Kind::sphere
  double ratio = 0;     // spread / ball, the median of comparisons
};

/// Throws std::invalid_argument for counts below 1.
MeshBench mesh_bench(std::size_t particles, int repeats);

}  // namespace motes::bench
