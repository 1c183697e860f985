// Projects particles to screen positions, a vector at a time: the values shared by plain code and the builds for each
// instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "simd/declare_builds.h"

namespace motes::image {

/// Flags in the upper bits of a number: the particle also touches the next column, or the next row, of tiles.
inline constexpr std::uint32_t kNextColumn = std::uint32_t{1} << 30;
inline constexpr std::uint32_t kNextRow = std::uint32_t{1} << 31;
inline constexpr std::uint32_t kNumberMask = kNextColumn - 1;

/// A Lens in single precision; `scale` is its focal length in the units of positions.
struct LensLanes {
  float eye[3], right[3], up[3], forward[3];
  float scale;
};

/// The input of all projections.
struct SeenTask {
  // Planes of floats. Where a plane is null, all particles have the value `..._of_all`.
  const float* position[3];
  const float* color[3];
  float color_of_all[3];
  const float* alpha;
  float alpha_of_all;
  const float* velocity[3];  // m/s
  float velocity_of_all[3];

  LensLanes now; // the frame's camera
  float near;    // m
  std::uint32_t dark; // 0xffffff: black particles are visible, too, because they hide others; 0: they are additive
  int width, height;      // px
  float limit_x, limit_y; // particles farther from the centre than this, in units of positions, touch no pixel

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
  std::uint32_t* color;     // r | g << 8 | b << 16 | alpha << 24; only the first one if all have the same
  std::uint32_t* depth;     // bits of the float view depth; null: not wanted
  std::uint16_t* tile;      // number of the first tile touched
  std::uint32_t* several;   // particles that touch several tiles: index of each, and flags
  std::uint32_t* velocity;  // bits of three floats, `velocity_stride` words apart; null: not wanted
  std::size_t velocity_stride;
};

struct ProjectedCount {
  std::size_t visible = 0, several = 0;
};

struct ProjectLanes {
  /// Projects particles first .. last-1 (first: a multiple of 16) and returns how many there are in `out`.
  ProjectedCount (*project)(const ProjectTask& task, std::size_t first, std::size_t last, const ProjectedBatch& out);
};

/// Returns the build for this processor.
const ProjectLanes& project_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::ProjectLanes, project_lanes)
