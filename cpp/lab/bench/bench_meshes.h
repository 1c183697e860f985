// Measures bouncing off a mesh, and making its signed distance field.
#pragma once

#include <cstddef>

namespace motes::bench {

/// Costs on one core with a ball of some 10,000 triangles and a grid of 96 cells along each axis. Times are the minimum
/// of the repeats, in nanoseconds per particle and step of only `bounce`. Particles move 2 cells per step.
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

/// Runs the benchmark. Throws std::invalid_argument for counts below 1.
MeshBench mesh_bench(std::size_t particles, int repeats);

}  // namespace motes::bench
