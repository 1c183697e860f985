// The whole picture drawn by one rank: scenery and the records of all calculators become one frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/liquid/liquids.h"
#include "image/pixels.h"
#include "image/post/bloom.h"
#include "image/post/bloom_tiles.h"
#include "image/post/layers.h"
#include "image/post/picture_light.h"
#include "image/post/tile_worker.h"
#include "image/raster/pieces.h"
#include "image/raycast/prepared_scene.h"
#include "threads/pool.h"

namespace motes::image {

/// Usage: begin, add for each message, finish; then again for the next frame. Pixels depend only on the particles, not
/// on the order, number or grouping of messages. Working memory and scenery are kept from frame to frame.
class Canvas {
 public:
  explicit Canvas(const SplatLanes& lanes = splat_lanes()) : workers_(lanes) {}

  /// Starts a frame. `keep_linear`: finish() also keeps the light for linear(). `pool`: its threads share the tiles
  /// until finish() has returned. `shadows`: see Scenery::prepare. Throws std::invalid_argument for an invalid view.
  void begin(const View& view, bool keep_linear = false, threads::Pool& pool = threads::alone(),
             const ShadowGrids* shadows = nullptr);

  /// Takes a part of the frame's records; the bytes must not change until finish() has returned. Throws
  /// std::runtime_error if they are malformed or made for a different view.
  void add(std::span<const std::byte> records) { messages_.add(records); }

  /// Draws the frame: 8-bit sRGB (red, green, blue), rows from top to bottom, height * width * 3 bytes. The second form
  /// fills memory of exactly that size, or throws std::invalid_argument.
  Pixels finish();
  void finish(std::span<std::uint8_t> pixels);

  /// Returns the last frame's light before exposure and roll-off: linear RGB, height * width * 3. Throws
  /// std::logic_error if that frame was begun without keep_linear.
  std::vector<float> linear() const;

  /// Returns the last frame's layers.
  const Layers& layers() const { return layers_; }

 private:
  void paint(const Area& area, std::size_t worker, std::uint8_t* pixels);
  void keep_or_show(const TileLight& light, const Area& area, std::size_t worker, std::uint8_t* pixels);
  void add_liquids();
  void paint_behind_liquids(const Area& area, TileWorker& by);
  void finish_liquids(std::uint8_t* pixels);
  void begin_bloom();
  void show_bloom(std::uint8_t* pixels);
  template <class Work>
  void each_tile(const Work& work);
  void show(const TilePainter& painter, const TileLight& light, const Area& area, std::uint8_t* pixels);
  void show_scenery(const Area& area, TilePainter& painter, std::uint8_t* pixels);
  std::size_t row_lanes() const { return static_cast<std::size_t>(scene_.grid().width) * 3; }
  std::size_t at(const Area& area) const;
  std::size_t size() const { return row_lanes() * static_cast<std::size_t>(scene_.grid().height); }

  PreparedScene scene_;
  Pixels scenery_pixels_;            // tone-mapped: what a tile without records shows
  std::vector<std::uint64_t> shown_versions_;  // by tile: that of the scene that they show
  bool keep_linear_ = false, light_kept_ = false;
  Pieces messages_;
  threads::Pool* pool_ = nullptr;
  TileWorkers workers_;
  Layers layers_;
  PictureLight light_;  // in use if keep_linear_, or with liquids
  Liquids liquids_;
  BloomTiles bloom_tiles_;
  Bloom bloom_;
};

}  // namespace motes::image
