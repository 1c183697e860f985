#include "image/scenery.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "image/camera.h"
#include "image/caster.h"
#include "image/splat_lanes.h"
#include "image/vectors.h"

namespace motes::image {
namespace {

// What the pixels of a tile and those next to it belong to: an edge may run along the tile's own.
constexpr int kBordered = kTile + 2;
using Surfaces = std::array<std::uint32_t, static_cast<std::size_t>(kBordered) * kBordered>;
constexpr std::size_t bordered(int x, int y) { return static_cast<std::size_t>((y + 1) * kBordered + x + 1); }

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

// The mean of four samples on a rotated grid: nearly vertical or horizontal edges get four steps.
Vector smooth(const Caster& caster, int x, int y) {
  return (caster.cast(x + 0.375, y + 0.125).light + caster.cast(x + 0.875, y + 0.375).light +
          caster.cast(x + 0.625, y + 0.875).light + caster.cast(x + 0.125, y + 0.625).light) *
         0.25;
}

}  // namespace

bool same_scenery(const View& a, const View& b) {
  return a.width == b.width && a.height == b.height && a.camera == b.camera && a.background == b.background &&
         a.objects == b.objects;
}

void Scenery::prepare(const View& view) {
  check(view);
  if (version_ != 0 && same_scenery(view, view_)) return;
  view_ = view;
  grid_ = {view.width, view.height};
  for (std::size_t c = 0; c < 3; ++c) background_[c] = to_scenery(view.background[c]);
  tiles_.resize(index(grid_.tiles()));
  ++version_;
}

void Scenery::render(std::span<const int> tiles) {
  Caster caster(view_);
  for (const int tile : tiles) {
    if (tile < 0 || tile >= grid_.tiles()) throw std::invalid_argument("no tile " + std::to_string(tile));
    if (!rendered(tile)) render_tile(caster, tile);
  }
}

void Scenery::render_all() {
  std::vector<int> all(index(grid_.tiles()));
  std::iota(all.begin(), all.end(), 0);
  render(all);
}

void Scenery::render_tile(Caster& caster, int number) {
  Tile& tile = tiles_[index(number)];
  const int left = number % grid_.columns() * kTile, top = number / grid_.columns() * kTile;
  const int width = std::min(kTile, grid_.width - left), height = std::min(kTile, grid_.height - top);
  tile.nearest = kNothing;
  tile.farthest = 0;
  tile.version = version_;
  if (!caster.aim(left - 1, top - 1, left + width + 1, top + height + 1)) return;

  tile.light.resize(index(3 * kTile * kTile));
  tile.depth.resize(index(kTile * kTile));
  Surfaces surfaces;
  const auto inside = [&](int x, int y) { return x >= 0 && y >= 0 && x < width && y < height; };
  for (int y = -1; y <= height; ++y) {
    for (int x = -1; x <= width; ++x) {
      const Sample sample = caster.cast(left + x + 0.5, top + y + 0.5);
      surfaces[bordered(x, y)] = sample.surface;
      if (!inside(x, y)) continue;
      std::uint16_t* light = tile.light.data() + 3 * within(x, y);
      sample.surface == 0 ? void(std::copy(background_.begin(), background_.end(), light)) : store(sample.light, light);
      const std::uint32_t depth = depth_bits(sample.depth);
      tile.depth.data()[within(x, y)] = depth;
      tile.nearest = std::min(tile.nearest, depth);
      tile.farthest = std::max(tile.farthest, depth);
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint32_t* here = surfaces.data() + bordered(x, y);
      const bool last_x = left + x + 1 == grid_.width, last_y = top + y + 1 == grid_.height;
      const bool edge = (left + x > 0 && here[-1] != *here) || (!last_x && here[1] != *here) ||
                        (top + y > 0 && here[-kBordered] != *here) || (!last_y && here[kBordered] != *here);
      if (edge) store(smooth(caster, left + x, top + y), tile.light.data() + 3 * within(x, y));
    }
  }
}

}  // namespace motes::image
