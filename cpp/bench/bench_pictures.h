// What a picture costs one core, in the terms of render_costs.h: `python -m motes bench costs`.
#pragma once

#include <cstddef>

namespace motes::bench {

/// Nanoseconds, each the median over repeats.
struct PictureBench {
  double project = 0;        // a particle: projected, culled, sorted by tile
  double record = 0;         // a record of an additive disc of 5 pixels, drawn
  double pixel = 0;          // a pixel of a tile: started, tone-mapped
  double bloom_pixel = 0;    // a pixel of a tile with bloom: kept, averaged, mixed with what glows there
  double spread_pixel = 0;   // on the image generator alone: averages of all tiles become their glow
  double partial_pixel = 0;  // a pixel of a partial tile: cleared and packed, or merged: the mean of both
};

/// Particles all over a picture, so that partial tiles are full. Throws std::invalid_argument where a number is not
/// positive or the picture is too large.
PictureBench picture_bench(std::size_t particles, int width, int height, int repeats);

}  // namespace motes::bench
