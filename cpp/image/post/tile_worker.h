// What one thread needs to paint tiles.
#pragma once

#include <deque>
#include <vector>

#include "image/buffer.h"
#include "image/raster/pieces.h"
#include "image/raster/tile_painter.h"
#include "image/raycast/prepared_scene.h"

namespace motes::image {

/// Working memory, kept from tile to tile.
struct TileWorker {
  explicit TileWorker(const SplatLanes& lanes = splat_lanes()) : painter(lanes) {}

  TilePainter painter;
  std::vector<Piece> pieces;  // of the tile that it paints
  Buffer partial;
};

/// One per thread. They stay where they are while others are added.
class TileWorkers {
 public:
  explicit TileWorkers(const SplatLanes& lanes = splat_lanes()) : lanes_(&lanes) {}

  /// Makes as many ready to paint tiles of the scene as there are threads.
  void begin(const PreparedScene& scene, int threads) {
    while (workers_.size() < static_cast<std::size_t>(threads)) workers_.emplace_back(*lanes_);
    for (TileWorker& worker : workers_) worker.painter.begin(scene);
  }

  TileWorker& operator[](std::size_t worker) { return workers_.at(worker); }

 private:
  const SplatLanes* lanes_;
  std::deque<TileWorker> workers_;
};

}  // namespace motes::image
