// Working memory of threads that paint tiles.
#pragma once

#include <deque>
#include <vector>

#include "image/buffer.h"
#include "image/raster/pieces.h"
#include "image/raster/tile_painter.h"
#include "image/raycast/prepared_scene.h"

namespace motes::image {

/// Working memory of one thread, kept from tile to tile.
struct TileWorker {
  explicit TileWorker(const SplatLanes& lanes = splat_lanes()) : painter(lanes) {}

  TilePainter painter;
  std::vector<Piece> pieces;  // of the tile being painted
  Buffer partial;
};

/// One TileWorker per thread. Adding more of them does not move the others.
class TileWorkers {
 public:
  explicit TileWorkers(const SplatLanes& lanes = splat_lanes()) : lanes_(&lanes) {}

  /// Prepares one worker per thread for painting tiles of the scene.
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
