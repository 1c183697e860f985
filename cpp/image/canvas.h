// The image generator's picture: scenery and the records of all calculators become one frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/footprint.h"
#include "image/records.h"
#include "image/scene.h"
#include "image/scenery.h"
#include "image/splat_lanes.h"

namespace motes::image {

/// Usage: begin, add for each message, finish; then again for the next frame. Pixels depend only on the particles, not
/// on the order, number or grouping of messages, because light is summed in integers. Working memory and scenery are
/// kept from frame to frame; the scenery is rendered again where camera, size, background or objects have changed.
class Canvas {
 public:
  explicit Canvas(const SplatLanes& lanes = splat_lanes());

  /// `keep_linear`: finish() also keeps the light for linear(). Throws std::invalid_argument where the view is not
  /// valid.
  void begin(const View& view, bool keep_linear = false);

  /// Takes a part of the frame's records; the bytes must not change until finish() has returned. Throws
  /// std::runtime_error where they are malformed or made for a different view.
  void add(std::span<const std::byte> records);

  /// The frame: sRGB, 8 bits, red green blue, rows from top to bottom: height * width * 3 bytes. The second form fills
  /// memory of exactly that size, or throws std::invalid_argument.
  std::vector<std::uint8_t> finish();
  void finish(std::span<std::uint8_t> pixels);

  /// The last frame's light before exposure and roll-off: linear RGB, height * width * 3. Throws std::logic_error where
  /// that frame was begun without keep_linear.
  std::vector<float> linear() const;

 private:
  struct Part {
    RecordsView records;
    Splat splat;
  };
  struct Piece {
    const Part* part;
    RecordsView::Piece records;
  };
  struct Area {
    int tile, x, y, width, height;  // pixels
  };

  std::size_t collect(int tile);
  void start_tile(const Area& area);
  void splat_tile(const Area& area);
  void show_tile(const Area& area, std::uint8_t* pixels);
  void copy_scenery(const Area& area, std::uint8_t* pixels);
  void render_scenery();
  std::size_t at(int x, int y) const;

  const SplatLanes* lanes_;
  View view_;
  Grid grid_;
  bool keep_linear_ = false;
  bool scenery_current_ = false;
  Scenery scenery_;
  std::vector<std::uint8_t> tone_;
  std::vector<std::uint8_t> scenery_pixels_;  // tone-mapped: what a tile without records shows
  std::vector<Part> parts_;
  std::vector<Piece> pieces_;  // of the current tile
  std::vector<float> linear_;

  // The current tile's sums, and the scenery's depth in the same layout.
  BufferOf<std::uint32_t> light_;
  BufferOf<std::uint32_t> depth_;
  TileSums sums_{};
};

}  // namespace motes::image
