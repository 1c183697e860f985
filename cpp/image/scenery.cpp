#include "image/scenery.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "image/camera.h"
#include "image/caster.h"
#include "image/splat_lanes.h"
#include "image/vectors.h"

namespace motes::image {
namespace {

std::uint16_t to_scenery(double linear) {
  const double scaled = linear * (static_cast<double>(kUnit) / (1 << kSceneryShift)) + 0.5;
  return scaled < 65535 ? static_cast<std::uint16_t>(scaled) : std::uint16_t{65535};
}

void store(const Vector& light, std::uint16_t* to) {
  for (std::size_t c = 0; c < 3; ++c) to[c] = to_scenery(light[c]);
}

std::uint32_t depth_bits(double depth) {
  // Nothing can be hidden beyond a float's range.
  constexpr double kLargest = std::numeric_limits<float>::max();
  return depth < kLargest ? std::bit_cast<std::uint32_t>(static_cast<float>(depth)) : Scenery::kNothing;
}

// True where an edge runs between the pixel and one of its four neighbours.
bool on_edge(const std::uint32_t* surface, const Grid& grid, int x, int y) {
  const std::uint32_t* here = surface + static_cast<std::ptrdiff_t>(y) * grid.width + x;
  return (x > 0 && here[-1] != *here) || (x + 1 < grid.width && here[1] != *here) ||
         (y > 0 && here[-grid.width] != *here) || (y + 1 < grid.height && here[grid.width] != *here);
}

// The mean of four samples on a rotated grid: nearly vertical or horizontal edges get four steps.
Vector smooth(const Caster& caster, int x, int y) {
  return (caster.cast(x + 0.375, y + 0.125).light + caster.cast(x + 0.875, y + 0.375).light +
          caster.cast(x + 0.625, y + 0.875).light + caster.cast(x + 0.125, y + 0.625).light) *
         0.25;
}

}  // namespace

void Scenery::render(const View& view) {
  check(view);
  grid_ = {view.width, view.height};
  for (std::size_t c = 0; c < 3; ++c) background_[c] = to_scenery(view.background[c]);
  ranges_.clear();
  if (view.objects.empty()) return;

  const std::size_t pixels = index(grid_.width) * index(grid_.height);
  light_.resize(3 * pixels);
  depth_.resize(pixels);
  surface_.resize(pixels);
  Caster caster(view);
  for_each_tile([&](int left, int top, int right, int bottom) {
    const bool seen = caster.aim(left, top, right, bottom);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) set(x, y, seen ? caster.cast(x + 0.5, y + 0.5) : Sample{});
    }
  });
  for_each_tile([&](int left, int top, int right, int bottom) {
    caster.aim(left, top, right, bottom);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        if (on_edge(surface_.data(), grid_, x, y)) store(smooth(caster, x, y), light_.data() + 3 * at(x, y));
      }
    }
  });
  find_ranges();
}

template <class Use>
void Scenery::for_each_tile(const Use& use) const {
  for (int y = 0; y < grid_.height; y += kTile) {
    for (int x = 0; x < grid_.width; x += kTile) {
      use(x, y, std::min(x + kTile, grid_.width), std::min(y + kTile, grid_.height));
    }
  }
}

void Scenery::set(int x, int y, const Sample& sample) {
  std::uint16_t* light = light_.data() + 3 * at(x, y);
  if (sample.surface == 0) {
    std::copy(background_.begin(), background_.end(), light);
  } else {
    store(sample.light, light);
  }
  depth_.data()[at(x, y)] = depth_bits(sample.depth);
  surface_.data()[at(x, y)] = sample.surface;
}

void Scenery::find_ranges() {
  ranges_.assign(index(grid_.tiles()), Range{});
  for (int y = 0; y < grid_.height; ++y) {
    for (int x = 0; x < grid_.width; ++x) {
      Range& range = ranges_[index((y >> kTileBits) * grid_.columns() + (x >> kTileBits))];
      const std::uint32_t depth = depth_.data()[at(x, y)];
      range.nearest = std::min(range.nearest, depth);
      range.farthest = std::max(range.farthest, depth);
    }
  }
}

}  // namespace motes::image
