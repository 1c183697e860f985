// Particles of any size, with streaks and directions, to screen positions: the values shared by plain code and the
// per-ISA builds.
#pragma once

#include <cstddef>
#include <cstdint>

namespace motes::image {

/// A Lens in single precision; `scale` is its focal length in 1/256 px.
struct LensLanes {
  float eye[3], right[3], up[3], forward[3];
  float scale;
};

struct WideTask {
  // Planes of floats; null: the value beside it holds for all particles.
  const float* position[3];
  const float* color[3];
  float color_of_all[3];
  const float* alpha;
  float alpha_of_all;
  const float* size;  // m
  float size_of_all;
  const float* up[3];
  float up_of_all[3];
  const float* velocity[3];
  float velocity_of_all[3];

  LensLanes now;   // the frame's camera
  LensLanes then;  // the camera when the shutter opened
  float near;      // m
  bool streaks;    // the shutter is open for a while
  float open;      // for how long, s

  std::uint32_t dark;  // 0xffffff: black particles are seen too, because they hide; else 0
  float diameter;      // px, of all particles; 0: `size` says
  bool oriented;       // sprites are squares, turned by `up`
  int width, height;   // px

  // 1/256 px from the centre: what is farther out touches no pixel.
  float limit_x, limit_y;
};

/// The visible particles, in their order. Each array has room for as many particles as are projected, plus one vector.
struct WideBatch {
  std::uint32_t* records;     // WideRecords, without velocity
  std::uint32_t* first_tile;  // column | row << 16 of the first tile that the bounding box touches
  std::uint32_t* last_tile;   // and of the last
  std::uint32_t* velocity;  // bits of three floats, each `velocity_stride` words after the one before; null: not wanted
  std::size_t velocity_stride;
};

struct ProjectWideLanes {
  /// Projects particles first .. last-1 (first: a multiple of 16) and returns how many are visible.
  std::size_t (*project)(const WideTask& task, std::size_t first, std::size_t last, const WideBatch& out);
};

/// The build that suits this processor.
const ProjectWideLanes& project_wide_lanes();

}  // namespace motes::image

namespace motes::sse2 {
extern const image::ProjectWideLanes project_wide_lanes;
}
namespace motes::avx2 {
extern const image::ProjectWideLanes project_wide_lanes;
}
namespace motes::avx512 {
extern const image::ProjectWideLanes project_wide_lanes;
}
