// The scenery of one tile at the exposures of a picture.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "image/exposures.h"
#include "image/raycast/cast_scene.h"
#include "image/raycast/scenery.h"
#include "image/raycast/tile_caster.h"

namespace motes::image {

/// Casts rays from each exposure's camera through the pixels of its phase. Holds the working memory of one thread.
class SceneryExposer {
 public:
  explicit SceneryExposer(const CastLanes& lanes = cast_lanes()) : lanes_(&lanes) {}

  /// Selects a scenery; its view and shadows must not change before the last exposure is computed.
  void begin(const Scenery& scenery);

  /// Computes one exposure of a tile: sums of light, in rows `light_stride` apart, and depth bits as Scenery::depth, in
  /// rows `depth_stride` apart.
  void expose(int number, const Area& area, std::uint32_t* light, std::ptrdiff_t light_stride, std::uint32_t* depth,
              std::ptrdiff_t depth_stride);

 private:
  // The scene at an exposure's camera, and the place of its pixels there.
  struct Shot {
    std::unique_ptr<CastScene> scene;
    float move_x, move_y;  // from a pixel's middle to the point whose ray is cast, px
  };

  Shot& shot(int number, int phase);
  std::size_t place(const Shot& shot, const Area& area, int phase);

  const CastLanes* lanes_;
  const Scenery* scenery_ = nullptr;
  std::uint64_t version_ = 0;
  std::array<std::array<Shot, kPhases>, kExposures> shots_;
  std::vector<float> x_, y_;
  std::vector<std::uint32_t> depth_, sums_, shadows_;
  std::array<std::vector<float>, 3> light_;
  SurfaceList met_;
};

}  // namespace motes::image
