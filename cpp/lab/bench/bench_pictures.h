// Measures what a picture costs one core, in the terms of render_costs.h: `python -m motes bench costs`.
#pragma once

#include <cstddef>

namespace motes::bench {

/// Nanoseconds, each the median over repeats.
struct PictureBench {
  double project = 0;        // per particle: project, cull, sort by tile
  double record = 0;         // per record of an additive disc of 5 pixels: draw
  double pixel = 0;          // per pixel of a tile: start, tone-map
  double bloom_pixel = 0;    // per pixel of a tile with bloom: keep, average, mix with the glow
  double spread_pixel = 0;   // per pixel, only on the image generator: turn averages of all tiles into glow
  double partial_pixel = 0;  // per pixel of a partial tile: clear and pack, or merge; the mean of both
};

/// Draws particles all over a picture, so that partial tiles are full. Throws std::invalid_argument if a number is not
/// positive or the picture is too large.
PictureBench picture_bench(std::size_t particles, int width, int height, int repeats);

}  // namespace motes::bench
