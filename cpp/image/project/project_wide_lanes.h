// Particles of any size, with streaks and directions, to screen positions: the values shared by plain code and the
// per-ISA builds.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/layout.h"
#include "image/project/project_lanes.h"
#include "particles/ids.h"
#include "particles/streams.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// Positions are in 1/256 px. Planes as in SeenTask.
struct WideTask : SeenTask {
  const float* size; // m
  float size_of_all;
  const float* up[3];
  float up_of_all[3];

  const float* gain = nullptr;  // of their light, from 1 on; null: 1

  LensLanes then; // the camera when the shutter opened
  bool streaks;   // the shutter is open for a while
  float open;     // for how long, s

  float diameter;  // px, of all particles; 0: `size` says
  float focus, blur;  // m to what is sharp; 1/64 px of blur, of what is infinitely far; 0: all is sharp
  bool oriented;   // sprites are squares, turned by `up`
  bool posed;      // sprites stand in space: the records are PosedRecords
  bool along_velocity;  // their fronts look there, else where `orientation` says
  const float* orientation[4];
  float orientation_of_all[4];
  const float* spin[3];  // rad/s about the world's axes
  float spin_of_all[3];
  float lens_focus, lens_blur;  // m to what is sharp; 1/256 px around what is infinitely far; 0: all is sharp
  float camera_turn[4];  // a quaternion: from the world's axes to the camera's
  float breadth;  // of a sprite whose size is 1: 1, but for meshes
  float diagonal;  // of a square of side 1; of a ball, its diameter
  int tiles;       // of the picture; 1: it is not cut
  const float* tile;      // their numbers; null: at random
  particles::Ids ids;     // from these,
  particles::DrawKey pick;  // by this key
  RecordForm form; // of the records
  int columns;     // of tiles
  int bits;        // of their positions
};

/// A particle whose bounding box touches more than 2x2 tiles, and the box: column | row << 16 of its first and last
/// tile.
struct ManyTiles {
  std::uint32_t particle, first, last;
};

/// What a batch has of its words: four of each record behind one another, then the next four. Where three are left the
/// fourth has no meaning; fewer are in columns.
inline constexpr std::size_t kFour = 4;
constexpr std::size_t fours_of(std::size_t words) { return (words + 1) / kFour; }

/// The visible particles, in their order. Each array has room for as many particles as are projected, plus two vectors.
struct WideBatch {
  /// Of records without velocity: see fours_of().
  std::uint32_t* words;
  std::size_t stride;      // from column to column
  std::uint16_t* tile;     // number of the first tile touched; of those that touch many, of one of them
  std::uint32_t* several;  // as in ProjectedBatch, without those that touch many
  ManyTiles* many;
  std::uint32_t* velocity;  // bits of three floats, in columns as well; null: not wanted
};

struct WideCount {
  std::size_t visible = 0, several = 0, many = 0;
  std::uint32_t color = 0;  // of all particles, where they have one: as in ProjectedBatch
};

struct ProjectWideLanes {
  /// Projects particles first .. last-1 (first: a multiple of 16) and returns how many there are in `out`.
  WideCount (*project)(const WideTask& task, std::size_t first, std::size_t last, const WideBatch& out);
};

/// The build that suits this processor.
const ProjectWideLanes& project_wide_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::ProjectWideLanes, project_wide_lanes)
