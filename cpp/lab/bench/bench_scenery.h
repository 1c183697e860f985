// Measures how fast scenery is rendered: `python -m motes bench scenery`.
#pragma once

#include <cstddef>
#include <string>

namespace motes::bench {

/// Milliseconds per frame on one core, without particles: medians.
struct SceneryBench {
  int width = 0, height = 0, frames = 0;
  std::size_t triangles = 0;  // of the mesh
  std::string isa;
  double ms_shapes = 0;         // the camera moves around eight shapes of different kinds on a plane, in the sun
  double ms_shapes_lights = 0;  // as ms_shapes, with three lights
  double ms_light_moves = 0;    // only one of these lights moves
  double ms_mesh = 0;           // the camera moves around a mesh on a plane
  double ms_build_mesh = 0;     // once per mesh: building its BVH
};

/// Runs the benchmark. Throws std::invalid_argument if a number is not positive or too large for a view.
SceneryBench scenery_bench(int width, int height, int frames);

}  // namespace motes::bench
