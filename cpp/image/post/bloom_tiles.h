// The tiles that one rank paints of a picture with bloom. Their light is kept until the glow around them is known.
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

/// Usage: begin for each frame; keep for each tile; when Bloom has spread the light of all ranks, mix for each tile.
/// keep() and mix() may run in several threads, one call per tile each. Pixels do not depend on the owners of tiles.
class BloomTiles {
 public:
  explicit BloomTiles(const BloomLanes& kernels = bloom_lanes()) : kernels_(&kernels) {}

  /// Makes room for these tiles of a picture, and for this many threads. Throws std::invalid_argument if the view's
  /// bloom is not in 0..1.
  void begin(const View& view, std::vector<Area> tiles, int threads);

  /// Keeps the light of a tile, and averages it.
  void keep(std::size_t tile, const TileLight& light, std::size_t worker);

  /// Return the cells around a tile, and the averages that keep() has computed for Bloom::add().
  const CellArea& cells(std::size_t tile) const { return tiles_[tile].cells; }
  std::span<const std::uint64_t> averages(std::size_t tile) const;

  /// Returns the light of a tile with the glow mixed in. `cells`: the picture's glow, at least in the cells around the
  /// tile. May be called once per tile.
  TileLight mix(std::size_t tile, const BloomCells& cells, std::size_t worker);

  std::size_t tiles() const { return tiles_.size(); }
  const BloomPlan& plan() const { return plan_; }

 private:
  struct Tile {
    Area area;
    CellArea cells;
    std::size_t averages;  // index of the first one
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
  BufferOf<std::uint64_t> averages_;  // tile by tile
  std::vector<Rows> rows_;            // one per worker
};

}  // namespace motes::image
