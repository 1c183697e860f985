// One liquid of a picture: all particles of one look as a smooth surface, in screen space (S. Green, Screen Space Fluid
// Rendering for Games, 2010; smoothed as in W. van der Laan et al., Screen Space Fluid Rendering with Curvature Flow,
// 2009, with the strides of a hierarchy of binomial filters).
//
//   records of a tile   add()      nearest depth, thickness, means of colours and speeds in cells of 8x8 px
//   all tiles           smooth()   depths without the bumps of particles
//                       shade()    light over what is behind
//
// Depths are least values and the rest are sums of integers, so the order of records does not matter.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/light/surface_light.h"
#include "image/liquid/liquid_lanes.h"
#include "image/raster/pieces.h"
#include "image/scene.h"
#include "threads/pool.h"

namespace motes::image {

/// The depth where there is no liquid, m; it is compared with half of it.
inline constexpr float kNoLiquid = 2e30f;

/// A picture to which liquids are added. Rows of depths are `row` apart and readable 16 numbers beyond their ends.
struct LiquidPicture {
  std::uint32_t* light;
  const std::uint32_t* behind;  // the same light, without what is in front of liquids
  const float* depth;  // of the nearest opaque surface, m; infinite where there is none
  std::ptrdiff_t row;
};

class LiquidSurface {
 public:
  /// Prepares for a frame.
  void begin(const LiquidSprite& look, const View& view);
  const LiquidSprite& look() const { return look_; }

  /// Sets a tile to the records of these pieces; once per tile of a frame. Threads may work on different tiles at the
  /// same time.
  void add(const Area& area, std::span<const Piece> pieces);

  /// Returns whether any tile has some of the liquid.
  bool any() const;
  bool any(int tile) const { return most_[static_cast<std::size_t>(tile)] > 0; }

  void smooth(threads::Pool& pool);
  void shade(const LiquidPicture& picture, threads::Pool& pool) const;

  /// Returns the depths of a row of pixels, m.
  const float* depth(int y) const { return depth_.data() + at(0, y); }

 private:
  static constexpr int kMostStride = 64;
  static constexpr int kPad = 2 * kMostStride;  // px on both sides of a row of depths

  float add(const Area& area, const Piece& piece, LiquidTile& tile) const;
  std::uint32_t speed_of(const std::byte* velocity) const;
  void keep(const Area& area, const LiquidTile& tile);
  template <class Work>
  void each_run(threads::Pool& pool, const Work& work) const;
  void smooth_rows(BufferOf<float>& to, const BufferOf<float>& from, int stride, bool across,
                   threads::Pool& pool) const;
  void mix_sums(int y, int x, int count, float* to) const;

  std::ptrdiff_t stride() const { return grid_.width + 2 * kPad; }
  std::ptrdiff_t at(int x, int y) const { return y * stride() + kPad + x; }
  int cell_columns() const { return (grid_.width + kLiquidCell - 1) / kLiquidCell; }
  int cell_rows() const { return (grid_.height + kLiquidCell - 1) / kLiquidCell; }

  const LiquidLanes* lanes_ = &liquid_lanes();
  LiquidSprite look_;
  Grid grid_;
  float focal_ = 0;
  std::shared_ptr<const SurfaceLight> light_;
  // Tiles without the liquid hold kNoLiquid and 0 in all planes.
  BufferOf<float> depth_, other_;
  BufferOf<std::uint32_t> thickness_;
  std::array<std::vector<float>, LiquidMean::count> sums_;  // in cells
  std::vector<float> most_;  // by tile: the radius of its largest ball, px; 0: none
  std::vector<std::uint8_t> used_;  // by tile: whether its planes hold anything
};

}  // namespace motes::image
