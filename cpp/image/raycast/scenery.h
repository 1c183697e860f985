// The picture without particles: background and external objects (paper 3.2.4), as light and depth for each pixel.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/raycast/tile_caster.h"
#include "image/scene.h"
#include "threads/pool.h"

namespace motes::image {

/// Ray-cast objects, lit by the sun, a hemisphere of sky and the view's lights, with shadows and anti-aliased edges;
/// far away they fade into the background. A pure function of the view, independent of its exposure. Tiles are computed
/// independently, so a rank renders only those that it draws.
///
/// The surfaces that the camera's rays meet are kept while the camera and the objects' shapes stay the same, so lights,
/// colours and the background can change without casting those rays again.
///
/// Usage, for each frame: prepare, render, then the getters for rendered tiles. Several workers may render different
/// tiles at the same time.
class Scenery {
 public:
  /// The depth of a pixel where there is no object: the bits of infinity.
  static constexpr std::uint32_t kNothing = 0x7f800000;

  explicit Scenery(const CastLanes& lanes = cast_lanes()) : lanes_(&lanes) {}

  /// Selects the view. Tiles stay rendered if the view's scenery is the same as before. Throws std::invalid_argument if
  /// the view is not valid. `shadows`: shadows of particles in this view, which must stay valid until the last tile is
  /// rendered; null: particles cast none.
  void prepare(const View& view, std::size_t workers = 1, const ShadowGrids* shadows = nullptr);

  /// Renders a tile, unless it is rendered already. Throws std::invalid_argument if there is no such tile.
  void render(int tile, std::size_t worker = 0);
  void render_all(threads::Pool& pool = threads::alone());

  const View& view() const { return view_; }
  const ShadowGrids* shadows() const { return shadows_; }

  /// Returns whether the exposures of this view differ in their scenery, which must then be computed for each: see
  /// SceneryExposer. The getters below describe the sharp scenery of the closing shutter.
  bool blurs() const { return blurs_; }

  /// Changes whenever the scenery does. Results computed from a tile stay valid while the version is the same.
  std::uint64_t version() const { return version_; }
  bool rendered(int tile) const { return tiles_[index(tile)].version == version_; }

  /// Returns whether an object or a sky is visible in this tile; if not, its pixels have the background's colour.
  bool occupied(int tile) const { return tiles_[index(tile)].occupied; }

  /// Return the least and the greatest depth in an occupied tile, as bits of floats.
  std::uint32_t nearest(int tile) const { return tiles_[index(tile)].nearest; }
  std::uint32_t farthest(int tile) const { return tiles_[index(tile)].farthest; }

  /// Bounds on the surfaces of an occupied tile, by block of 8x8 pixels: the least surface depth, FLT_MAX where there
  /// is none; the greatest depth from which on one of them hides particles, 0 where there is none; and the greatest
  /// distance between the two, m.
  /// Where it is less, a surface's bias (see CastLanes::measure) grows with its slope.
  static constexpr float kSteepBias = 0.019f;
  struct Blocks {
    float nearest[kBlocks][kBlocks], hides[kBlocks][kBlocks], bias[kBlocks][kBlocks];
    /// Bit x of a row of 64 is set if the relative bias is more than kSteepBias.
    std::uint32_t steep[kTile][2];
  };
  const Blocks& blocks(int tile) const { return tiles_[index(tile)].blocks; }

  /// Returns sums of light, three per pixel, from (x, y) to the end of its tile's row. The next row is 3 * kTile
  /// numbers further on. Only for occupied tiles.
  const std::uint32_t* light(int x, int y) const { return tile_of(x, y).light.data() + 3 * within(x, y); }
  const std::array<std::uint32_t, 3>& background() const { return background_; }
  /// Returns the greatest of a tile's sums.
  std::uint32_t brightest(int tile) const {
    return occupied(tile) ? tiles_[index(tile)].brightest : *std::max_element(background_.begin(), background_.end());
  }

  /// Returns the bits of the view depths, from (x, y) to the end of its tile's row, beyond which particles are hidden:
  /// the depth of the surface plus a small bias, so that particles resting on it are fully visible. The next row is
  /// kTile numbers further on. Only for occupied tiles.
  const std::uint32_t* depth(int x, int y) const { return tile_of(x, y).depth.data() + within(x, y); }
  /// Returns the depths of the surfaces themselves, m, from (x, y) to the end of its tile's row; FLT_MAX where there is
  /// none. Only for occupied tiles.
  const float* surface_depth(int x, int y) const {
    return tile_of(x, y).surfaces.depths(x & (kTile - 1), y & (kTile - 1));
  }

  /// Returns the distance between the planes of an occupied tile's surfaces (see SurfaceList), the first of which has
  /// their depths; the others have the same rows, of kSurfaceStride.
  std::ptrdiff_t surface_plane(int tile) const { return tiles_[index(tile)].surfaces.centers.plane(); }

  /// The axes of the camera, and the side of a pixel at a view depth of 1 m, m.
  struct Eye {
    std::array<float, 3> right{}, up{}, forward{};
    float pixel = 0;
  };
  const Eye& eye() const { return eye_; }
  const Grid& grid() const { return grid_; }

 private:
  struct Tile {
    std::uint64_t forms = 0;    // version of the surfaces
    std::uint64_t version = 0;  // of the light
    bool occupied = false;
    std::uint32_t nearest = kNothing;
    std::uint32_t farthest = 0;
    Blocks blocks;
    TileSurfaces surfaces;
    std::uint32_t brightest = 0;
    BufferOf<std::uint32_t> light;  // kTile rows of 3 * kTile numbers
    BufferOf<std::uint32_t> depth;  // kTile rows of kTile numbers
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static std::size_t within(int x, int y) { return index((y & (kTile - 1)) * kTile + (x & (kTile - 1))); }
  const Tile& tile_of(int x, int y) const {
    return tiles_[index((y >> kTileBits) * grid_.columns() + (x >> kTileBits))];
  }
  // Working memory of a worker. Each has its own scene, which selects the objects and lights that matter for a tile.
  struct Worker {
    TileCaster caster;
    std::unique_ptr<CastScene> scene;
    std::uint64_t version = 0;
  };

  void trace(Tile& tile, const TilePart& part, Worker& by) const;
  static void measure(Tile& tile, const TilePart& part);

  View view_;
  bool blurs_ = false;
  const ShadowGrids* shadows_ = nullptr;
  Grid grid_;
  Eye eye_;
  std::uint64_t forms_ = 0;
  std::uint64_t version_ = 0;
  std::array<std::uint32_t, 3> background_{};
  const CastLanes* lanes_;
  std::vector<Worker> workers_;
  std::vector<Tile> tiles_;
};

}  // namespace motes::image
