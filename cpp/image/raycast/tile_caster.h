// Casts rays through the pixels of a tile, and computes the light of the surfaces that they meet.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/raycast/cast_scene.h"
#include "image/tile_planes.h"

namespace motes::image {

/// Memory for surfaces: see Surfaces.
class SurfaceList {
 public:
  /// Sets the number of surfaces. `triangles`: whether they include the numbers of a mesh's triangles.
  void resize(std::size_t count, bool triangles);
  std::size_t size() const { return count_; }
  /// Returns the surfaces from number `first` on.
  Surfaces from(std::size_t first);
  const float* distances(std::size_t first) const { return planes_.data() + first; }
  /// Returns the distance between planes: of distances, the components of the normals, and the surfaces.
  std::ptrdiff_t plane() const { return static_cast<std::ptrdiff_t>(stride_); }

 private:
  std::size_t count_ = 0, stride_ = 0;
  bool triangles_ = false;
  BufferOf<float> planes_;
};

/// The part of the image that a tile covers, px.
struct TilePart {
  int left, top, width, height;
};

/// The surfaces that a tile shows. They depend on the camera and the objects' shapes, not on light or colour.
struct TileSurfaces {
  /// Returns the view depths from a pixel to the end of its row, m; FLT_MAX where there is no surface.
  const float* depths(int x, int y) const { return centers.distances(center(x, y)); }
  static std::size_t center(int x, int y) {
    return static_cast<std::size_t>(y + 1) * kSurfaceStride + static_cast<std::size_t>(x + 1);
  }

  SurfaceList centers;  // at pixel centres: kTile + 2 rows of kSurfaceStride, with the adjacent pixels around the tile
  SurfaceList border;  // the adjacent pixels again: kTile above, below, left and right
  std::vector<std::uint32_t> edge_pixels;  // 64 y + x of pixels on an edge
  SurfaceList edges;  // samples of edge_pixels, pixel by pixel
  Reach reach;
};

/// Traces and shades tiles, each independently of the others. Holds the working memory of one thread.
class TileCaster {
 public:
  explicit TileCaster(const CastLanes& lanes = cast_lanes()) : lanes_(&lanes) {}

  /// Finds the surfaces, and the depth bits of each pixel: kTile rows of kTile. Returns false if neither an object nor
  /// a sky is visible. `smooth`: edges are anti-aliased; must be the same as for shade().
  bool trace(CastScene& scene, const TilePart& part, bool smooth, TileSurfaces& to, std::uint32_t* depth);

  /// Computes the light of each pixel, as the scenery stores it: kTile rows of kTile pixels.
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
  std::vector<float> x_, y_;  // points, px
  std::vector<float> center_x_, center_y_;  // centres of the points' pixels, px
  std::vector<float> light_[3];  // of the tile's pixels
  std::vector<float> sampled_[3];  // of samples
  std::vector<std::uint32_t> shadows_, ignored_;  // Shades::shadows of pixels, arranged like centers; of samples
  std::vector<std::uint32_t> shadow_pixels_;  // on the edge of a shadow
  std::vector<std::uint8_t> on_edge_;  // per pixel of the tile
  SurfaceList shadow_edges_;
  std::vector<std::uint32_t> blocks_;  // all pixels of the tile, in blocks
  SurfaceList in_blocks_;
};

}  // namespace motes::image
