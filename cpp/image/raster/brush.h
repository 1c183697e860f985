// A brush draws the records of one sprite; it is prepared once per frame.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/footprint.h"
#include "image/layout.h"
#include "image/raster/splat_lanes.h"
#include "image/raster/wide_lanes.h"
#include "image/scene.h"

namespace motes::image {

/// Tables of a fixed-size sprite that is not a plain footprint. Rows are ordered as in Footprint.
struct SurfaceTables {
  std::vector<std::uint8_t> weights, cover;  // three per pixel
  std::vector<std::uint16_t> covered;        // one bit per pixel of a row
  std::vector<std::uint32_t> shade;          // as Splat::shade; empty: fully lit
  std::vector<float> bulge;                  // as Splat::bulge; empty: flat
};

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
  bool tests_pixels() const { return layout_ == Layout::ribbon || (is_posed(sprite_) && wide_.blur > 0); }

  /// Returns whether streaks are drawn from stamps.
  bool has_stamps() const { return wide_.one_size; }

  /// Returns whether records of this sprite and layout are drawn by this brush.
  bool same(const Sprite& sprite, Layout layout, bool colored = true) const {
    return sprite == sprite_ && layout == layout_ && colored == colored_;
  }

  /// Orders brushes by what they draw, so that every rank gets the same order.
  std::strong_ordering operator<=>(const Brush& other) const;
  bool operator==(const Brush& other) const { return same(other.sprite_, other.layout_, other.colored_); }

 private:
  void set_splat(const View& view);
  void set_wide(const View& view);
  void set_mesh();
  const Footprint& footprint_in_use() const;

  Sprite sprite_;
  Layout layout_;
  bool colored_;
  std::size_t record_bytes_;
  int width_, height_;
  Footprint own_; // of a sprite whose size is a fraction of the picture's height
  SurfaceTables tables_;
  Splat splat_{};
  WideSplat wide_{};
};

}  // namespace motes::image
