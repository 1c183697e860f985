// Projects particles of any size, with streaks and orientations, to screen positions: the values shared by plain code
// and the builds for each instruction set.
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

  const float* gain = nullptr;  // factors on their light, at least 1; null: 1

  LensLanes then; // the camera when the shutter opened
  bool streaks;   // the exposure time is not 0
  float open;     // exposure time, s

  float diameter;  // of all particles, px; 0: from `size`
  float focus, blur;  // focus distance, m; blur diameter at infinity, 1/64 px; 0: all is sharp
  bool oriented;   // sprites are squares, turned by `up`
  bool posed;      // sprites are cards or meshes: the records are PosedRecords
  bool along_velocity;  // their fronts face along the velocity; otherwise `orientation` turns them
  bool toward_camera;  // their fronts face the camera, turned by `up`
  const float* orientation[4];
  float orientation_of_all[4];
  const float* spin[3];  // rad/s about the world's axes
  float spin_of_all[3];
  float lens_focus, lens_blur;  // of sprites that painters blur: focus distance, m; radius at infinity, 1/256 px
  bool opaque;  // narrow sprites do not get fainter
  float camera_turn[4];  // quaternion from the world's axes to the camera's
  float breadth;  // width of a sprite of size 1: 1, except for meshes
  float diagonal;  // diameter of a posed sprite's bounding ball, relative to the sprite's width
  int tiles;       // of the picture; 1: it is not divided
  const float* tile;      // tile numbers; null: random ones
  particles::Ids ids;     // of particles, for random tile numbers
  particles::DrawKey pick;  // key of random tile numbers
  RecordForm form; // of the records
  int columns;     // of tiles
  int bits;        // fractional bits of their positions
};

/// A particle whose bounding box touches more than 2x2 tiles, and the box's first and last tile: column | row << 16.
struct ManyTiles {
  std::uint32_t particle, first, last;
};

/// A batch stores the words of records in groups of four: the first four of all records, then the next four, and so on.
/// If three are left, they form a group with an undefined fourth word; one or two are stored as columns.
inline constexpr std::size_t kFour = 4;
constexpr std::size_t fours_of(std::size_t words) { return (words + 1) / kFour; }

/// The visible particles, in their order. Each array has room for as many particles as are projected, plus two vectors.
struct WideBatch {
  /// Words of records without velocity: see fours_of().
  std::uint32_t* words;
  std::size_t stride;      // numbers from column to column
  std::uint16_t* tile;     // number of the first tile touched; if it touches many, of any of them
  std::uint32_t* several;  // as in ProjectedBatch, without those that touch many
  ManyTiles* many;
  std::uint32_t* velocity;  // bits of three floats, in three columns; null: not wanted
  bool boxes = false;  // particles touch all tiles of their boxes, because painters blur them
};

struct WideCount {
  std::size_t visible = 0, several = 0, many = 0;
  std::uint32_t color = 0;  // of all particles, if they have the same: as in ProjectedBatch
};

struct ProjectWideLanes {
  /// Projects particles first .. last-1 (first: a multiple of 16) and returns how many there are in `out`.
  WideCount (*project)(const WideTask& task, std::size_t first, std::size_t last, const WideBatch& out);
};

/// Returns the build for this processor.
const ProjectWideLanes& project_wide_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::ProjectWideLanes, project_wide_lanes)
