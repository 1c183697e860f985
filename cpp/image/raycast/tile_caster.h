// What rays through the pixels of one tile meet, and what light comes back.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/raycast/cast_scene.h"

namespace motes::image {

/// Surfaces in memory of their own: see Surfaces.
class SurfaceList {
 public:
  /// `triangles`: with numbers of those of meshes.
  void resize(std::size_t count, bool triangles);
  std::size_t size() const { return count_; }
  /// From the given one on.
  Surfaces from(std::size_t first);
  const float* distances(std::size_t first) const { return planes_.data() + first; }
  std::array<float, 3> normal(std::size_t i) const {
    return {planes_.data()[stride_ + i], planes_.data()[2 * stride_ + i], planes_.data()[3 * stride_ + i]};
  }
  std::uint32_t surface(std::size_t i) const { return std::bit_cast<std::uint32_t>(planes_.data()[4 * stride_ + i]); }

 private:
  std::size_t count_ = 0, stride_ = 0;
  bool triangles_ = false;
  BufferOf<float> planes_;
};

/// The part of the image that a tile covers, pixels.
struct TilePart {
  int left, top, width, height;
};

/// All that a tile shows of objects: it depends on the camera and the objects' forms, not on light or colour.
struct TileSurfaces {
  /// View depths from a pixel to the end of its row, m; FLT_MAX where nothing is met.
  const float* depths(int x, int y) const { return centers.distances(center(x, y)); }
  std::array<float, 3> normal(int x, int y) const { return centers.normal(center(x, y)); }
  std::uint32_t surface(int x, int y) const { return centers.surface(center(x, y)); }
  static std::size_t center(int x, int y) {
    return static_cast<std::size_t>(y + 1) * (kTile + 2) + static_cast<std::size_t>(x + 1);
  }

  SurfaceList centers;  // met at the centres of pixels: kTile + 2 rows of kTile + 2, the neighbours' first ones around
  SurfaceList border;  // these neighbours again: kTile above, below, left and right
  std::vector<std::uint32_t> edge_pixels;  // 64 y + x of pixels on an edge
  SurfaceList edges;  // their samples, one pixel's after the other's
  Reach reach;
};

/// Working memory to fill tiles, of one thread. Each tile is computed alone.
class TileCaster {
 public:
  explicit TileCaster(const CastLanes& lanes = cast_lanes()) : lanes_(&lanes) {}

  /// Finds the surfaces, and the bits of depth of each pixel: kTile rows of kTile. Returns false where no object is
  /// visible. `smooth`: for shade() with the same.
  bool trace(CastScene& scene, const TilePart& part, bool smooth, TileSurfaces& to, std::uint32_t* depth);

  /// Finds the light of each pixel, as the scenery stores it: kTile rows of kTile pixels.
  void shade(CastScene& scene, const TilePart& part, bool smooth, TileSurfaces& from, std::uint32_t* light);

 private:
  void place_row(const TilePart& part, int y);
  void place_border(const TilePart& part);
  void place_blocks(const TilePart& part);
  void place_samples(const TilePart& part, const std::vector<std::uint32_t>& pixels);
  void reserve_points(std::size_t count);
  void put_in_blocks(std::vector<std::uint32_t>& pixels);
  void reserve_samples(std::size_t count);
  Shades samples();
  void trace_blocks(const CastView& view, const TilePart& part, TileSurfaces& to);
  void shade_blocks(const ShadeView& view, const TilePart& part, TileSurfaces& from);
  void trace_edges(const CastView& view, const TilePart& part, bool meshes, TileSurfaces& to);
  void find_shadow_edges(const ShadeView& view, const TilePart& part, bool meshes, TileSurfaces& from);
  void shade_samples(const ShadeView& view, const std::vector<std::uint32_t>& pixels, SurfaceList& surfaces);

  const CastLanes* lanes_;
  std::vector<float> x_, y_;  // points, pixels
  std::vector<float> center_x_, center_y_;  // of the pixels that they are in
  std::vector<float> light_[3];  // of the tile's pixels
  std::vector<float> sampled_[3];  // of samples
  std::vector<std::uint32_t> shadows_, ignored_;  // marks like centers; of samples
  std::vector<std::uint32_t> shadow_pixels_;  // on the edge of a shadow
  std::vector<std::uint8_t> on_edge_;  // per pixel of the tile
  SurfaceList shadow_edges_;
  std::vector<std::uint32_t> blocks_;  // all pixels of the tile, in blocks
  SurfaceList in_blocks_;
};

}  // namespace motes::image
