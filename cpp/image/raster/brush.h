// A brush draws the records of one sprite; it is prepared once per frame. The tile painter sends each piece of records
// one of six ways, by the layout of the records, the sprite's kind and blend, and whether something may hide them:
//
//   records of one fixed size, up to kMaxFootprint px (layouts plain, deep): Splat, tables of weights
//     add      points without depth    1 point_lanes.h    a vector of points at a time, 2x2 px each
//              without depth           2 splat_lanes.cpp  each row of its footprint, times its colour (add_records)
//              with depth, in a tile   3 tested_lanes.h   the same for those in front of everything near them; the
//                that has surfaces                        others pixel by pixel; hidden ones are skipped
//     alpha                            2 splat_lanes.cpp  from far to near, always tested (over_records)
//     opaque                           4 opaque_lanes.h   the nearest surface per pixel, in TilePlanes::surfaces
//
//   all other records (layouts from sized on): WideSplat and the splat of their kind
//     add,     points, discs           5 disc_lanes.h     groups of kWidth discs: weights first, then light
//     alpha    the same, of one size       stamp_lanes.h  streaks from Stamps; those of one colour are added up in a
//                and with streaks                         Cover first; long ones alone, by 6
//              spheres, images, cards, 6 wide_lanes.cpp   one by one: a Patch of weights from kind_*.h, then light
//                meshes, ribbons           (draw_one)     row by row; small still images from ImageStamps
//     opaque   meshes, ribbons           kind_*.h         draw(): they know their depth at each pixel
//              all other kinds           wide_lanes.cpp   front() of each kind, kept where it is nearest (opaque_wide)
//              all, through a lens or    exposed_lanes.h  the same at each exposure (tile_exposures.cpp)
//                an open shutter
//
// Before, records just behind a surface are made deeper (behind.h), and those of a tile in which any blends by alpha
// are sorted by depth (ordered.h). Visibility is tested only where TilePlanes::hides, by blocks of pixels
// (depth_blocks.h) where that decides.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include "image/balls/ball_tile.h"
#include "image/footprint.h"
#include "image/layout.h"
#include "image/raster/splat_lanes.h"
#include "image/raster/splats.h"
#include "image/scene.h"

namespace motes::image {

/// Tables of a fixed-size sprite that is not a plain footprint. Rows are ordered as in Footprint.
struct SurfaceTables {
  std::vector<std::uint8_t> cover;     // three per pixel
  std::vector<std::uint16_t> covered;  // one bit per pixel of a row
  std::vector<float> bulge;            // as Splat::bulge; empty: flat
};

using KindSplat = std::variant<std::monostate, DiscSplat, SphereSplat, PictureSplat, SpaceSplat, CardSplat, MeshSplat>;

class Brush {
 public:
  /// `colored`: whether records carry colours.
  Brush(const Sprite& sprite, Layout layout, const View& view, bool colored = true);

  const Sprite& sprite() const { return sprite_; }
  Layout layout() const { return layout_; }
  bool colored() const { return colored_; }
  RecordForm form() const { return image::form(layout_, colored_); }
  bool blends(Sprite::Blend blend) const { return sprite_.blend == blend; }
  std::size_t record_bytes() const { return record_bytes_; }

  /// Returns the drawing parameters for the tile whose first pixel is (x, y).
  Splat splat_at(int x, int y) const;
  WideSplat wide_at(const Area& area) const;

  /// Returns a footprint's side, px; 0: each record has its own size.
  int footprint_pixels() const { return of_fixed_size(layout_) ? splat_.size : 0; }

  /// Returns whether its sprites test visibility at each pixel: ribbons, and cards and meshes seen through a lens.
  bool tests_pixels() const { return layout_ == Layout::ribbon || (is_posed(sprite_) && blurs_); }

  /// Returns whether it is worth keeping while the view stands: it has what was costly to make.
  bool lasts() const { return balls_ != nullptr; }

  /// Returns whether its surfaces may be brighter than white.
  bool bright() const { return light_ != nullptr; }

  /// Returns whether streaks are drawn from stamps.
  bool has_stamps() const {
    const auto* discs = std::get_if<DiscSplat>(&kind_);
    return discs != nullptr && discs->one_size;
  }

  /// Returns whether records of this sprite and layout are drawn by this brush.
  bool same(const Sprite& sprite, Layout layout, bool colored = true) const {
    return sprite == sprite_ && layout == layout_ && colored == colored_;
  }

  /// Orders brushes by what they draw, so that every rank gets the same order.
  std::strong_ordering operator<=>(const Brush& other) const;
  bool operator==(const Brush& other) const { return same(other.sprite_, other.layout_, other.colored_); }

 private:
  void set_records(RecordSplat& to) const;
  void set_splat(const View& view);
  void set_wide(const View& view);
  const Footprint& footprint_in_use() const;

  Sprite sprite_;
  Layout layout_;
  bool colored_;
  std::size_t record_bytes_;
  int width_, height_;
  bool blurs_;
  Footprint own_; // of a sprite whose size is a fraction of the picture's height
  SurfaceTables tables_;
  std::shared_ptr<Balls> balls_;  // of spheres; each tile is drawn by one thread at a time
  Splat splat_{};
  WideSplat wide_{};
  KindSplat kind_;  // of wide_
  std::shared_ptr<const SurfaceLight> light_;
};

}  // namespace motes::image
