#include "image/raycast/scenery.h"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <string>

#include "image/camera.h"
#include "image/checks.h"
#include "image/exposures.h"
#include "image/tile_planes.h"

namespace motes::image {
namespace {

std::uint32_t to_sum(float linear) {
  return static_cast<std::uint32_t>(std::min(linear * static_cast<float>(kUnit) + 0.5f, kMostScenery));
}

// Returns whether rays from the camera meet the same surfaces in both views.
bool same_forms(const View& a, const View& b) {
  const auto same = [](const Solid& x, const Solid& y) {
    return x.mesh == y.mesh && x.shape == y.shape && (x.glass > 0) == (y.glass > 0);
  };
  return a.width == b.width && a.height == b.height && a.camera == b.camera && a.smooth == b.smooth &&
         (a.sky.kind == Sky::Kind::none) == (b.sky.kind == Sky::Kind::none) && a.bare == b.bare &&
         std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(), same);
}

// Returns whether the exposures of equal surfaces are the same in both views.
bool same_exposures(const View& a, const View& b) {
  return (!scenery_blurs(a) && !scenery_blurs(b)) || (a.shutter == b.shutter && a.before == b.before);
}

// Returns whether the light on equal surfaces is the same in both views.
bool same_light(const View& a, const View& b) {
  return same_exposures(a, b) && a.background == b.background && a.sky == b.sky && a.fog == b.fog &&
         a.objects == b.objects && a.sun == b.sun && a.sun_color == b.sun_color && a.sun_power == b.sun_power &&
         a.sun_size == b.sun_size && a.lights == b.lights && a.occlusion == b.occlusion;
}

}  // namespace

void Scenery::prepare(const View& view, std::size_t workers, const ShadowGrids* shadows) {
  check(view);
  while (workers_.size() < workers) workers_.push_back({TileCaster(*lanes_), nullptr, 0});
  const bool forms = version_ != 0 && same_forms(view, view_);
  if (forms && same_light(view, view_) && shadows == nullptr && shadows_ == nullptr) return;
  auto scene = std::make_unique<CastScene>(view, shadows);  // may throw: nothing has changed yet
  if (!forms) ++forms_;
  ++version_;
  workers_[0].scene = std::move(scene);
  workers_[0].version = version_;
  view_ = view;
  blurs_ = scenery_blurs(view);
  shadows_ = shadows;
  grid_ = {view.width, view.height};
  for (std::size_t c = 0; c < 3; ++c) background_[c] = view.bare ? 0 : to_sum(view.background[c]);
  tiles_.resize(index(grid_.tiles()));
  const Lens through = lens(view);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    eye_.right[axis] = static_cast<float>(through.right[axis]);
    eye_.up[axis] = static_cast<float>(through.up[axis]);
    eye_.forward[axis] = static_cast<float>(through.forward[axis]);
  }
  eye_.pixel = static_cast<float>(1 / through.focal_px);
}

void Scenery::render(int number, std::size_t worker) {
  if (number < 0 || number >= grid_.tiles()) throw std::invalid_argument("no tile " + std::to_string(number));
  if (rendered(number)) return;
  Worker& by = workers_.at(worker);
  if (by.version != version_) {
    by.scene = std::make_unique<CastScene>(view_, shadows_);
    by.version = version_;
  }
  Tile& tile = tiles_[index(number)];
  TilePart part{number % grid_.columns() * kTile, number / grid_.columns() * kTile, 0, 0};
  part.width = std::min(kTile, grid_.width - part.left);
  part.height = std::min(kTile, grid_.height - part.top);
  if (tile.forms != forms_) trace(tile, part, by);
  if (tile.occupied) {
    tile.light.resize(index(3 * kTile * kTile));
    by.caster.shade(*by.scene, part, view_.smooth, tile.surfaces, tile.light.data());
    tile.brightest = 0;
    for (int y = 0; y < part.height; ++y) {
      const std::uint32_t* row = tile.light.data() + 3 * kTile * y;
      tile.brightest = std::max(tile.brightest, *std::max_element(row, row + 3 * part.width));
    }
  }
  tile.version = version_;
}

void Scenery::render_all(threads::Pool& pool) {
  pool.run(tiles_.size(), [&](std::size_t tile, std::size_t worker) { render(static_cast<int>(tile), worker); });
}

void Scenery::trace(Tile& tile, const TilePart& part, Worker& by) const {
  tile.depth.resize(index(kTile * kTile));
  tile.occupied = by.caster.trace(*by.scene, part, view_.smooth, tile.surfaces, tile.depth.data());
  tile.forms = forms_;
  if (tile.occupied) measure(tile, part);
}

void Scenery::measure(Tile& tile, const TilePart& part) {
  constexpr float kNone = std::numeric_limits<float>::max();
  tile.nearest = kNothing;
  tile.farthest = 0;
  tile.blocks = {};
  std::fill_n(tile.blocks.nearest[0], kBlocks * kBlocks, kNone);
  for (int y = 0; y < part.height; ++y) {
    const std::uint32_t* row = tile.depth.data() + y * kTile;
    const float* surfaces = tile.surfaces.depths(0, y);
    for (int x = 0; x < part.width; ++x) {
      tile.nearest = std::min(tile.nearest, row[x]);
      tile.farthest = std::max(tile.farthest, row[x]);
      if (surfaces[x] == kNone) continue;
      const float hides = std::bit_cast<float>(row[x]);
      const int down = y >> kBlockBits, right = x >> kBlockBits;
      float &nearest = tile.blocks.nearest[down][right], &farthest = tile.blocks.hides[down][right];
      float& bias = tile.blocks.bias[down][right];
      nearest = std::min(nearest, surfaces[x]);
      farthest = std::max(farthest, hides);
      bias = std::max(bias, hides - surfaces[x]);
      tile.blocks.steep[y][x / 32] |= std::uint32_t{hides > (1 + kSteepBias) * surfaces[x]} << (x % 32);
    }
  }
}

}  // namespace motes::image
