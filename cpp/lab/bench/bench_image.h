// Measures how fast frames are drawn: `python -m motes bench render`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace motes::bench {

/// One way to draw the same particles.
struct RenderRow {
  std::string name;
  std::string kind, blend;
  int pixels = 0;
  double ms_per_frame = 0;  // median
  double ms_project = 0;
  double ratio = 0;  // to additive discs: the median over pairs of consecutive frames
};

/// Milliseconds of CPU time on one core. A frame covers everything from the particles' planes to sRGB pixels.
struct RenderBench {
  std::size_t particles = 0;
  int width = 0, height = 0, pixels = 0, frames = 0;
  std::string isa;
  std::size_t records = 0;  // in all tiles of one frame
  std::size_t bytes = 0;    // of all messages of one frame
  double ms_per_frame = 0;  // median
  double ms_per_frame_min = 0;
  double ms_project = 0;  // median: project, cull, sort by tile
  double ms_splat = 0;    // median: sum light, tone map
  std::vector<RenderRow> rows;
};

/// Draws snow: eight systems with `particles` in total, uniform in a box of which about 89 % is visible, in random
/// order, as discs of `pixels` diameter; or as many particles of eight fountains. Then draws the same particles as
/// sprites of all kinds in all blends: the rows, of which the first is additive discs once more. Throws
/// std::invalid_argument if a number is not positive or too large for a view.
RenderBench render_bench(std::size_t particles, int width, int height, int pixels, int frames, bool fountain = false);

}  // namespace motes::bench
