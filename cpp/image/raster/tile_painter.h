// Paints one tile of the picture: turns scenery and records into light.
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
#include "image/raster/wide_lanes.h"
#include "image/raycast/prepared_scene.h"
#include "image/raycast/scenery_exposer.h"
#include "image/tile_light.h"

namespace motes::image {

/// Usage: begin for each frame; then for each tile start or start_bare, merge for each partial tile, paint once, and
/// any of show, light, depth and save_partial. Pixels depend only on the set of particles, not on the order or grouping
/// of their records, nor on the partial tiles in which they were first added up. A painter holds the working memory of
/// one tile; each thread needs its own.
///
/// Through a lens or an open shutter, pixels with something opaque are means of exposures: see image/exposures.h. Such
/// tiles have no partial tiles.
///
/// Visibility is decided per pixel: the nearest opaque particle or solid hides everything behind it. All other
/// particles are drawn in front of it: they are added in any order if none of the tile's records is blended by alpha;
/// otherwise all of them, additive ones too, are blended from far to near.
class TilePainter {
 public:
  explicit TilePainter(const SplatLanes& lanes = splat_lanes(), const WideLanes& wide = wide_lanes());

  /// Starts a frame. The scene must not change before its last tile is painted.
  void begin(const PreparedScene& scene);

  /// Starts a tile with the scenery's light and depth.
  void start(const Area& area);

  /// Starts a partial tile, without light, to be merged into another. The scenery still hides what is behind it.
  void start_bare(const Area& area);

  /// Merges a partial tile that save_partial() wrote, here or on another rank. Throws std::runtime_error if it is
  /// malformed or of another tile.
  void merge(std::span<const std::byte> partial);

  /// Draws all records of this tile that have not been merged. A partial tile takes either opaque records, or additive
  /// ones of a frame without other blends, so that partial tiles can be merged in any order; throws std::logic_error
  /// otherwise.
  void paint(std::span<const Piece> pieces);

  /// Appends a partial tile to `to`: the pixels that have light or an opaque particle.
  void save_partial(Buffer& to) const;

  /// Returns the tile's light, valid until the next start.
  TileLight light() const { return {planes_.light, kLightStride, area_.width, area_.height, area_.x, area_.y}; }

  /// Writes light as sRGB, three bytes per pixel; the tile's first pixel is at `pixels`, a row of the picture has
  /// `row_bytes` bytes. The first form writes this tile's light.
  void show(std::uint8_t* pixels, std::size_t row_bytes) const { show(light(), pixels, row_bytes); }
  void show(const TileLight& light, std::uint8_t* pixels, std::size_t row_bytes) const;

  /// Writes the view depth of the nearest solid or opaque particle, m; infinite if there is none.
  void depth(float* depths, std::size_t row_floats) const;

  /// Writes the coverage, 0..1, of the painted `pieces` and of the surfaces that hide some of them. Overwrites the
  /// tile's light.
  void alpha(std::span<const Piece> pieces, float* alphas, std::size_t row_floats);

  /// Replaces the light by that of the blended `pieces` in front of `depths`, m, and of the tile's surfaces. `passed`:
  /// by the part, in kUnit, of light from behind that they let through.
  void front(std::span<const Piece> pieces, const float* depths, std::size_t row_floats, bool passed);

  /// Writes the velocity of the nearest opaque particle of the painted `pieces`, m/s, three floats per pixel; 0 where
  /// something else is nearer.
  void velocity(std::span<const Piece> pieces, float* velocities, std::size_t row_floats);

 private:
  void clear(const Area& area, std::uint32_t brightest);
  void take_depth();
  void show_scenery();
  void show_surfaces();
  void paint_blended(std::span<const Piece> pieces);
  void show_passed(std::span<const Piece> pieces);
  void start_surfaces();
  void paint_surfaces(std::span<const Piece> pieces);
  void draw_opaque(const Piece& given, const TilePlanes& planes);

  // In tile_exposures.cpp.
  bool has_exposures(std::span<const Piece> pieces) const;
  void paint_exposures(std::span<const Piece> pieces);
  void expose(std::span<const Piece> pieces);
  void start_exposure(int number);
  void begin_blending();
  void keep_exposure(int number, bool back);
  void measure_depth();
  void measure_sharp(std::span<const Piece> pieces, bool opaque);
  bool in_front(std::span<const Piece> pieces, std::uint32_t nearest) const;
  void add_exposure();
  void show_exposures();

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

  // The brush in use, and its parameters for this tile: most pieces need the same brush as the one before.
  const Brush* brush_ = nullptr;
  Splat splat_{};
  WideSplat wide_splat_{};

  // Light that can still be added to any sum without overflow; and whether sums may have overflowed already.
  std::uint32_t room_ = 0;
  bool saturating_ = false;

  BufferOf<std::uint32_t> light_, depth_;
  BufferOf<NearestSurface> nearest_;
  TilePlanes planes_{};
  DepthBlocks blocks_, fronts_;  // ranges of the tile's depths; ranges of surfaces while they are drawn
  BufferOf<ImageStamp> image_stamps_;
  BufferOf<Stamp> stamps_;  // several megabytes, which a std::vector would put in small pages

  // Accumulates streaks of the brush covering_, if any.
  BufferOf<std::uint16_t> cover_weights_;
  BufferOf<std::uint32_t> cover_sums_;
  Cover cover_;
  const Brush* covering_ = nullptr;
  Ordered ordered_;
  Behind behind_;

  // Of exposures: surfaces of opaque particles, sums of light, and the scenery.
  BufferOf<NearestSurface> exposed_;
  BufferOf<std::uint64_t> sums_;
  BufferOf<std::uint32_t> kept_;  // light and depth of each
  SceneryExposer exposer_;
  const Exposure* phases_ = nullptr;  // of the exposure that is drawn; null: of none
};

}  // namespace motes::image
