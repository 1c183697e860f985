// Scenes for the image tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/post/canvas.h"
#include "image/project/projector.h"
#include "image/project/records.h"
#include "image/raster/tile_painter.h"
#include "image/scene.h"

namespace motes::image_test {

using namespace image;

/// Planes with the padding that Drawn requires.
struct Cloud {
  std::vector<float> plane[3], color[3], alpha;
  std::size_t count = 0;
  bool colored = false;
  float alpha_of_all = 1;  // where it is not coloured

  explicit Cloud(std::size_t n = 0, bool with_color = false) : count(n), colored(with_color) {
    for (auto& p : plane) p.assign(n + 16, 0.0f);
    for (auto& c : color) c.assign(n + 16, 1.0f);
    alpha.assign(n + 16, 1.0f);
  }
  void place(std::size_t i, float x, float y, float z) {
    plane[0][i] = x;
    plane[1][i] = y;
    plane[2][i] = z;
  }
  Drawn drawn() const {
    Drawn d;
    d.count = count;
    for (std::size_t i = 0; i < 3; ++i) {
      d.position[i] = plane[i].data();
      d.color[i] = colored ? color[i].data() : nullptr;
    }
    d.alpha = colored ? alpha.data() : nullptr;
    d.alpha_of_all = alpha_of_all;
    return d;
  }
};

/// Returns random particles that fill more than the view of `small_view`.
Cloud random_cloud(std::size_t count, std::uint64_t seed, bool colored = true);

/// Returns every `step`-th particle, starting with `first`.
Cloud every(const Cloud& cloud, std::size_t first, std::size_t step);

/// Returns a view from (0, 0, 10) towards the origin.
View small_view(int width = 200, int height = 150);

/// Return the builds that this processor can run.
std::vector<const ProjectLanes*> usable_project_lanes();
std::vector<const SplatLanes*> usable_splat_lanes();

std::vector<std::byte> projected(const Drawn& drawn, const Sprite& sprite, const View& view,
                                 const Projection& projection, const ProjectLanes& lanes = project_lanes(),
                                 const ProjectWideLanes& wide = project_wide_lanes());
std::vector<std::byte> message(const Cloud& cloud, const Sprite& sprite, const View& view,
                               const ProjectLanes& lanes = project_lanes());
Pixels picture(const View& view, const std::vector<std::vector<std::byte>>& messages,
               const SplatLanes& lanes = splat_lanes());

/// Returns sums of light as linear RGB, before exposure and roll-off.
std::vector<float> linear_of(const std::vector<std::uint32_t>& sums);

/// Returns what a painter has made of a tile: linear RGB, three numbers per pixel.
std::vector<float> light_of(const TilePainter& painter, const Area& area);

}  // namespace motes::image_test
