// One tile of the picture: scenery and records become light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "image/buffer.h"
#include "image/pieces.h"
#include "image/prepared_scene.h"
#include "image/splat_lanes.h"

namespace motes::image {

/// Usage: begin for each frame; then for each tile start or start_bare, merge for each partial tile, paint once, and
/// any of show, sums, light and save_partial. Pixels depend only on the set of particles, not on the order or grouping
/// of their records, nor on how many partial tiles they were first added up in. It holds the working memory of one
/// tile; there may be several, one per thread.
class TilePainter {
 public:
  explicit TilePainter(const SplatLanes& lanes = splat_lanes());

  /// The scene must not change before the frame's last tile is painted.
  void begin(const PreparedScene& scene);

  /// Starts with the scenery's light, and hides what is behind it.
  void start(const Area& area);

  /// Starts without light: for a partial tile, which is added to others. The scenery still hides what is behind it.
  void start_bare(const Area& area);

  /// Adds what save_partial() wrote, here or on another rank, for the same tile. Throws std::runtime_error where the
  /// bytes are malformed or of another tile.
  void merge(std::span<const std::byte> partial);

  /// Draws all records of this tile that have not been merged.
  void paint(std::span<const Piece> pieces);

  /// Appends the tile's light to `to`: the bounding box of all pixels that have some.
  void save_partial(Buffer& to) const;

  /// Writes sRGB, three bytes per pixel; the tile's first pixel is at `pixels`, a row of the picture has `row_bytes`.
  void show(std::uint8_t* pixels, std::size_t row_bytes) const;

  /// Writes the sums of light, three per pixel (see PictureLight); a row of the picture has `row_lanes`.
  void sums(std::uint32_t* to, std::size_t row_lanes) const;

  /// Writes linear RGB before exposure and roll-off, three floats per pixel; a row of the picture has `row_floats`.
  void light(float* linear, std::size_t row_floats) const;

 private:
  void start_depth();
  void add_records(const Piece& piece);
  const std::uint32_t* row(int y) const;

  const SplatLanes* lanes_;
  const PreparedScene* scene_ = nullptr;
  Area area_;

  // How many more records of full light can be added before a sum may overflow; and whether sums may have.
  std::uint32_t room_ = 0;
  bool saturating_ = false;

  // The tile's sums, and the scenery's depth in the same layout.
  BufferOf<std::uint32_t> light_;
  BufferOf<std::uint32_t> depth_;
  TileSums sums_{};
};

}  // namespace motes::image
