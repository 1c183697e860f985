// One tile of the picture: scenery and records become light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/raster/behind.h"
#include "image/raster/depth_blocks.h"
#include "image/raster/ordered.h"
#include "image/raster/pieces.h"
#include "image/raster/splat_lanes.h"
#include "image/raycast/prepared_scene.h"
#include "image/tile_light.h"

namespace motes::image {

/// Usage: begin for each frame; then for each tile start or start_bare, merge for each partial tile, paint once, and
/// any of show, sums, depth and save_partial. Pixels depend only on the set of particles, not on the order or
/// grouping of their records, nor on how many partial tiles they were first added up in. It holds the working memory of
/// one tile; there may be several painters, one per thread.
///
/// What hides what, pixel by pixel: opaque particles and the scenery hide what is behind them, the nearest wins. All
/// others are drawn before that: where none of a tile's records is blended by alpha they are added in any order;
/// otherwise all of them, additive ones too, are blended from far to near.
class TilePainter {
 public:
  explicit TilePainter(const SplatLanes& lanes = splat_lanes(), const WideLanes& wide = wide_lanes());

  /// The scene must not change before the frame's last tile is painted.
  void begin(const PreparedScene& scene);

  /// Starts with the scenery's light, and hides what is behind it.
  void start(const Area& area);

  /// Starts without light: for a partial tile, which is merged into another. The scenery still hides what is behind it.
  void start_bare(const Area& area);

  /// Adds what save_partial() wrote, here or on another rank, for the same tile. Throws std::runtime_error where the
  /// bytes are malformed or of another tile.
  void merge(std::span<const std::byte> partial);

  /// Draws all records of this tile that have not been merged. Partial tiles can be merged in any order, so a bare tile
  /// takes only opaque records, or only additive ones of a frame in which no system is opaque or blended by alpha:
  /// throws std::logic_error where its records are of another blend or of both.
  void paint(std::span<const Piece> pieces);

  /// Appends what a bare tile holds to `to`: the pixels that have light or an opaque particle.
  void save_partial(Buffer& to) const;

  /// The tile's light, until another one is started.
  TileLight light() const { return {planes_.light, kLightStride, area_.width, area_.height}; }

  /// Writes it as sRGB, three bytes per pixel; the tile's first pixel is at `pixels`, a row of the picture has
  /// `row_bytes`. The second form shows other light.
  void show(std::uint8_t* pixels, std::size_t row_bytes) const { show(light(), pixels, row_bytes); }
  void show(const TileLight& light, std::uint8_t* pixels, std::size_t row_bytes) const;

  /// Writes the view depth of the nearest solid or opaque particle, m; infinite where there is none.
  void depth(float* depths, std::size_t row_floats) const;

  /// Writes the part of the light from behind that the painted `pieces`, and what hides some of them, hold back, 0..1.
  /// Overwrites the tile's light.
  void alpha(std::span<const Piece> pieces, float* alphas, std::size_t row_floats);

  /// Writes the velocity of the nearest opaque particle of the painted `pieces`, m/s, three floats per pixel; 0 where
  /// something else is nearer.
  void velocity(std::span<const Piece> pieces, float* velocities, std::size_t row_floats);

 private:
  void clear(const Area& area, std::uint32_t brightest);
  void start_surfaces();
  void paint_surfaces(std::span<const Piece> pieces);
  void draw_opaque(const Piece& given, const TilePlanes& planes);
  void paint_bare(std::span<const Piece> pieces);
  void add(std::span<const Piece> pieces);
  void start_cover(std::span<const Piece> pieces);
  void show_cover();
  void end_cover();
  void blend(const Piece& given);
  template <class Draw>
  void in_parts(const Piece& piece, const Draw& draw);
  const WideKernels& kernels(const Brush& brush) const;
  void take_up(const Piece& piece);
  void set_brush(const Brush& brush);

  const SplatLanes* lanes_;
  const WideLanes* wide_lanes_;
  const PreparedScene* scene_ = nullptr;
  Area area_;
  bool bare_ = false;
  bool surfaces_ = false;  // planes_.surfaces is in use

  // The brush in use, for the tile: most pieces need the same one as the piece before them.
  const Brush* brush_ = nullptr;
  Splat splat_{};
  WideSplat wide_splat_{};

  // How much more light can be added to any sum before it may overflow; and whether sums may have.
  std::uint32_t room_ = 0;
  bool saturating_ = false;

  BufferOf<std::uint32_t> light_, depth_;
  BufferOf<Nearest> nearest_;
  TilePlanes planes_{};
  DepthBlocks blocks_, fronts_;  // of the tile's depths; of surfaces while they are drawn
  BufferOf<Stamp> stamps_;  // of several megabytes: a vector would have them in small pages

  // Where streaks are added up, while it is in use by records of this brush.
  BufferOf<std::uint16_t> cover_weights_;
  BufferOf<std::uint32_t> cover_sums_;
  Cover cover_;
  const Brush* covering_ = nullptr;
  Ordered ordered_;
  Behind behind_;
};

}  // namespace motes::image
