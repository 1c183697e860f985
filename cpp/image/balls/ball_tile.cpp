#include "image/balls/ball_tile.h"

#include <utility>

namespace motes::image {
namespace {

// Cells are so small that directions in one differ by at most 0.9 degrees from that of its middle.
constexpr double kCellsPerFocal = 44;
constexpr int kLeastCellBits = 2, kMostCellBits = 5;

// Phases are a quarter of a pixel for spheres of any size, because the units of a tile should stay in caches.
constexpr int kPhaseBits = 2;

// Bytes that vectors may read behind a unit.
constexpr std::size_t kBehind = 64;

int cell_bits(double focal_px) {
  int bits = kLeastCellBits;
  while (bits < kMostCellBits && static_cast<double>(2 << bits) * kCellsPerFocal <= focal_px) ++bits;
  return bits;
}

}  // namespace

Balls::Balls(const Grid& grid, const Footprint& f, float diameter, double focal_px, BallForm form, bool grey,
             std::shared_ptr<const SurfaceLight> light)
    : grid_(grid), light_(std::move(light)), look_{}, tiles_(static_cast<std::size_t>(grid.tiles())) {
  look_.form = form;
  look_.grey = grey;
  look_.size = f.size;
  look_.phase_bits = kPhaseBits;
  look_.phase_shift = f.phase_bits - kPhaseBits;
  const int in_row = f.size <= 8 ? 8 : 16;
  look_.row_bytes = form == BallForm::weights ? f.row_bytes : form == BallForm::shades ? in_row : 4 * in_row;
  look_.unit_bytes = f.size * look_.row_bytes;
  look_.radius_px = 0.5f * diameter;
  look_.per_pixel = static_cast<float>(1 / focal_px);
  look_.cell_bits = cell_bits(focal_px);
  const int cell = 1 << look_.cell_bits, half = cell / 2, reach = (kMaxFootprint + 1) / 2;
  look_.before = half > reach ? half : reach;
  look_.across = ((kTile - 1 + reach + look_.before) >> look_.cell_bits) + 1;
  look_.light = light_.get();
}

BallTile& Balls::tile(int x, int y) {
  std::unique_ptr<BallTile>& tile =
      tiles_[static_cast<std::size_t>((y >> kTileBits) * grid_.columns() + (x >> kTileBits))];
  if (tile == nullptr) {
    tile = std::make_unique<BallTile>();
    tile->look = &look_;
    const auto middle = [&](int first, int pixels) {
      return static_cast<float>(first - look_.before) + 0.5f * static_cast<float>((1 << look_.cell_bits) - pixels);
    };
    tile->first_x = middle(x, grid_.width);
    tile->first_y = middle(y, grid_.height);
    tile->begins.assign(static_cast<std::size_t>(look_.units()), 0);
    tile->begin = tile->begins.data();
    if (look_.form == BallForm::weights) {
      tile->means.assign(3 * static_cast<std::size_t>(look_.across * look_.across), -1.0f);
      tile->mean = tile->means.data();
    }
  }
  return *tile;
}

std::uint32_t BallTile::more() {
  if (all.empty()) all.resize(2 * kBehind);  // no unit begins at 0
  const std::size_t first = all.size() - kBehind;
  all.resize(all.size() + static_cast<std::size_t>(look->unit_bytes));
  bytes = all.data();
  return static_cast<std::uint32_t>(first);
}

}  // namespace motes::image
