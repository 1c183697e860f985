// The picture without particles: background and external objects (paper 3.2.4), as light and depth for each pixel.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/scene.h"

namespace motes::image {

struct Sample;

/// Ray-cast objects, lit by one sun and a hemisphere of sky, with shadows of the sun and anti-aliased edges; far away
/// they fade into the background. A pure function of the view, independent of its exposure.
class Scenery {
 public:
  /// The depth of a pixel where there is no object: the bits of infinity.
  static constexpr std::uint32_t kNothing = 0x7f800000;

  Scenery() = default;

  /// Renders the view's scenery. Throws std::invalid_argument where the view is not valid.
  void render(const View& view);

  /// False: no object is visible in this tile, its pixels are background.
  bool occupied(int tile) const { return !ranges_.empty() && ranges_[index(tile)].nearest != kNothing; }

  /// The least and greatest depth in an occupied tile.
  std::uint32_t nearest(int tile) const { return ranges_[index(tile)].nearest; }
  std::uint32_t farthest(int tile) const { return ranges_[index(tile)].farthest; }

  /// Light in units of 2^kSceneryShift sums (see splat_lanes.h): three numbers per pixel, from (x, y) to the end of the
  /// row. Only in occupied tiles.
  const std::uint16_t* light(int x, int y) const { return light_.data() + 3 * at(x, y); }
  const std::array<std::uint16_t, 3>& background() const { return background_; }

  /// Float bits of the view depth beyond which a particle is hidden: the depth of the surface plus a small bias, so
  /// that particles resting on a surface are fully visible. Only in occupied tiles.
  const std::uint32_t* depth(int x, int y) const { return depth_.data() + at(x, y); }

 private:
  struct Range {
    std::uint32_t nearest = kNothing;
    std::uint32_t farthest = 0;
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  std::size_t at(int x, int y) const { return index(y) * index(grid_.width) + index(x); }
  template <class Use>
  void for_each_tile(const Use& use) const;
  void set(int x, int y, const Sample& sample);
  void find_ranges();

  Grid grid_;
  std::array<std::uint16_t, 3> background_{};
  BufferOf<std::uint16_t> light_;
  BufferOf<std::uint32_t> depth_;
  BufferOf<std::uint32_t> surface_;
  std::vector<Range> ranges_;
};

}  // namespace motes::image
