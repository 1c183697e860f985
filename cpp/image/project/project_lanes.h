// Particles to screen positions, one vector at a time: the values shared by plain code and the per-ISA builds.
#pragma once

#include <cstddef>
#include <cstdint>

#include "simd/declare_builds.h"

namespace motes::image {

/// Flags beside a number: the particle also touches the next column of tiles, the next row.
inline constexpr std::uint32_t kNextColumn = std::uint32_t{1} << 30;
inline constexpr std::uint32_t kNextRow = std::uint32_t{1} << 31;
inline constexpr std::uint32_t kNumberMask = kNextColumn - 1;

/// A Lens in single precision; `scale` is its focal length in the units of
/// positions.
struct LensLanes {
  float eye[3], right[3], up[3], forward[3];
  float scale;
};

/// What all projections need.
struct SeenTask {
  // Planes of floats; null: the value beside it holds for all particles.
  const float* position[3];
  const float* color[3];
  float color_of_all[3];
  const float* alpha;
  float alpha_of_all;
  const float* velocity[3];  // m/s
  float velocity_of_all[3];

  LensLanes now; // the frame's camera
  float near;    // m
  std::uint32_t dark; // 0xffffff: black particles are seen too, because they hide; 0: particles are additive
  int width, height;      // px
  float limit_x, limit_y; // in the units of positions, from the centre: what is
                          // farther out touches no pixel

  bool one_color() const {
    return alpha == nullptr && color[0] == nullptr && color[1] == nullptr && color[2] == nullptr;
  }
};

struct ProjectTask : SeenTask {
  int columns, sub_bits, footprint; // see Grid
};

/// Values of the visible particles, in the order of the particles. Each array has room for as many as are projected,
/// plus two vectors.
struct ProjectedBatch {
  std::uint32_t* position;  // as in records: i16 x | i16 y << 16
  std::uint32_t* color;     // r | g << 8 | b << 16 | alpha << 24; of one colour only the first
  std::uint32_t* depth;     // bits of the float view depth; null: not wanted
  std::uint16_t* tile;      // number of the first tile touched
  std::uint32_t* several;   // those that touch several tiles, as many as there are: which one it is, and flags
  std::uint32_t*
      velocity;  // bits of three floats, each `velocity_stride` words behind the one before; null: not wanted
  std::size_t velocity_stride;
};

struct ProjectedCount {
  std::size_t visible = 0, several = 0;
};

struct ProjectLanes {
  /// Projects particles first .. last-1 (first: a multiple of 16) and returns how many there are in `out`.
  ProjectedCount (*project)(const ProjectTask& task, std::size_t first, std::size_t last, const ProjectedBatch& out);
};

/// The build that suits this processor.
const ProjectLanes& project_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::ProjectLanes, project_lanes)
