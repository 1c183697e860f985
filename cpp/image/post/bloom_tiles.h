// The tiles that one rank paints of a picture with bloom: their light waits until it is known what glows around them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/post/bloom_cells.h"
#include "image/post/bloom_plan.h"
#include "image/scene.h"
#include "image/tile_light.h"

namespace motes::image {

/// Usage: begin for each frame; keep for each tile; then, when Bloom has spread what all ranks kept, mix for each tile.
/// keep() and mix() may run in several threads, one call per tile each. Pixels do not depend on who owns which tile.
class BloomTiles {
 public:
  explicit BloomTiles(const BloomLanes& kernels = bloom_lanes()) : kernels_(&kernels) {}

  /// Makes room for these tiles of a picture, and for so many threads. Throws std::invalid_argument where its bloom is
  /// not in 0..1.
  void begin(const View& view, std::vector<Area> tiles, int threads);

  /// Keeps the light of a tile, and averages it.
  void keep(std::size_t tile, const TileLight& light, std::size_t worker);

  /// The cells around a tile, and what keep() has made for Bloom::add().
  const CellArea& cells(std::size_t tile) const { return tiles_[tile].cells; }
  std::span<const std::uint64_t> averages(std::size_t tile) const;

  /// The light of a tile that stays, and the glow around it: `cells` are at least those around it, of the whole
  /// picture's glow. To be called once.
  TileLight mix(std::size_t tile, const BloomCells& cells, std::size_t worker);

  std::size_t tiles() const { return tiles_.size(); }
  const BloomPlan& plan() const { return plan_; }

 private:
  struct Tile {
    Area area;
    CellArea cells;
    std::size_t averages;  // where they begin
  };
  // A thread's working memory.
  struct Rows {
    std::vector<std::uint64_t> sums;
    GlowRows glow;
  };

  std::uint32_t* light(std::size_t tile);

  const BloomLanes* kernels_;
  BloomPlan plan_;
  std::vector<Tile> tiles_;
  BufferOf<std::uint32_t> light_;     // tile by tile
  BufferOf<std::uint64_t> averages_;  // likewise
  std::vector<Rows> rows_;            // one per worker
};

}  // namespace motes::image
