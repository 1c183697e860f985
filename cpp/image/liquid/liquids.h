// The liquids of a picture, drawn over what is behind them. Blended particles in front are drawn over liquids.
//
//   tile by tile     add()         records of liquids
//   whole picture    added()
//   tile by tile     take()        the light and depth of everything else near liquids
//                    keep_front()  what is in front of them
//   whole picture    finish()      each liquid's surface, over the light behind, which it bends; then what is in front
//
// Two liquids of different looks are drawn one after the other; each hides the next where it is nearer.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/liquid/liquid.h"
#include "image/raster/tile_painter.h"

namespace motes::image {

class Liquids {
 public:
  /// Starts a frame with the looks that `pieces` has; returns whether there are any.
  bool begin(const View& view, const Pieces& pieces);

  /// Adds the liquids among the pieces of a tile; once per tile. Threads may work on different tiles at the same time,
  /// here and below.
  void add(const Area& area, std::span<const Piece> pieces);
  /// Ends add().
  void added();

  /// Returns whether liquids may show or hide anything of a tile.
  bool near(int tile) const { return near_[static_cast<std::size_t>(tile)] != 0; }

  /// Takes the depths of a near tile that `painter` has painted without liquids, and copies its light to `light`, whose
  /// rows are `row_lanes` apart.
  void take(const TilePainter& painter, std::uint32_t* light, std::size_t row_lanes);
  /// Keeps those of a tile's `others` that are in front of liquids. Overwrites the painter's light and depth.
  void keep_front(const Area& area, std::span<const Piece> others, TilePainter& painter);

  /// Draws the liquids over the picture's light, of which only near tiles are needed.
  void finish(std::uint32_t* light, threads::Pool& pool);

  /// Calls put(x, y, depth) for each pixel that shows a liquid, after finish().
  template <class Put>
  void each_pixel(const Put& put) const {
    for (int y = 0; y < grid_.height; ++y) {
      for (int x = 0; x < grid_.width; ++x) {
        if (shown_[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width) + static_cast<std::size_t>(x)])
          put(x, y, depth_.data()[y * row() + x]);
      }
    }
  }

 private:
  /// What is in front of liquids in a tile: its light, and the part, in kUnit, of the light behind that it lets
  /// through.
  struct Front {
    std::vector<std::uint32_t> light, passed;
  };

  bool any(int tile) const;
  void show(const LiquidSurface& liquid, const Area& area);
  void take_away_front(std::uint32_t* behind) const;
  void add_front(std::uint32_t* light) const;
  template <class Work>
  void each_near(threads::Pool& pool, const Work& work) const;
  template <class Work>
  void each_front_pixel(const Work& work) const;
  std::ptrdiff_t row() const { return grid_.width + 16; }

  Grid grid_;
  std::deque<LiquidSurface> liquids_;
  std::size_t count_ = 0;
  BufferOf<float> depth_;  // of the nearest opaque surface; after finish(), of the liquids in front of it
  BufferOf<std::uint32_t> behind_;
  std::vector<std::unique_ptr<Front>> fronts_;  // by tile
  std::vector<std::uint8_t> near_;   // by tile: whether liquids may show or hide anything of it
  std::vector<std::uint8_t> shown_;  // by pixel: whether it shows a liquid
};

/// Returns whether a piece is of a liquid.
inline bool is_liquid(const Piece& piece) { return piece.brush->sprite().is(Sprite::Kind::surface); }

}  // namespace motes::image
