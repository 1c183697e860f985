// The light on small spheres of one sprite, which all have one size in the picture: it depends on the direction in
// which they are seen, so it is computed for cells of the picture, and for each sub-pixel position ("phase").
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "image/footprint.h"
#include "image/grid.h"
#include "image/light/surface_light.h"

namespace motes::image {

/// What is kept of each pixel of a sphere.
enum class BallForm : std::uint8_t {
  weights,   // three bytes, as in Footprint: rows of row_bytes
  shades,    // a byte, 1..255, where light has no colour
  surfaces,  // four bytes: a surface as in NearestSurface, of a white sphere
};

/// How spheres of one size are lit and stored.
struct BallLook {
  BallForm form;
  bool grey;         // the light on them has no colour
  int size, phase_bits;
  int phase_shift;   // phases of the footprint are 2^phase_shift times as many along each axis
  int row_bytes;
  int unit_bytes;    // of all rows in one phase
  float radius_px;
  float per_pixel;   // side of a pixel at a depth of 1 m, m
  int cell_bits;     // cells have 2^cell_bits pixels per side
  int before, across;  // px from a tile's first cell to its first pixel; cells per row
  const SurfaceLight* light;  // without lamps

  constexpr int units() const { return (across * across) << (2 * phase_bits); }
};

/// The spheres of one tile. A unit is a phase in a cell; cells are those of the whole picture, so that the spheres at
/// the border of two tiles are the same in both. Units are made by kernels when they are first drawn.
struct BallTile {
  const BallLook* look;
  float first_x, first_y;  // middle of the first cell, px right of and below the picture's middle
  std::uint32_t* begin;    // of each unit in `bytes`; 0: it is not made
  unsigned char* bytes;
  float* mean;             // three numbers per cell, of weights: mean light on a sphere's disc; negative: not known

  /// Makes room for a unit and returns where it begins. What was returned before may move.
  std::uint32_t more();

  std::vector<std::uint32_t> begins;
  std::vector<unsigned char> all;
  std::vector<float> means;
};

/// The spheres of all tiles. Different threads may use different tiles at the same time.
class Balls {
 public:
  /// `diameter`: px. `grey`: the light has no colour. `light`: on the spheres.
  Balls(const Grid& grid, const Footprint& footprint, float diameter, double focal_px, BallForm form, bool grey,
        std::shared_ptr<const SurfaceLight> light);

  /// Returns the spheres of the tile whose first pixel is (x, y).
  BallTile& tile(int x, int y);

 private:
  Grid grid_;
  std::shared_ptr<const SurfaceLight> light_;
  BallLook look_;
  std::vector<std::unique_ptr<BallTile>> tiles_;
};

}  // namespace motes::image
