#include "image/post/bloom_tiles.h"

#include <algorithm>

namespace motes::image {
namespace {

constexpr std::size_t kRowLanes = 3 * kTile, kTileLanes = kRowLanes * kTile;

// Computes what a row of a tile, whose lanes are `sums`, adds to a row of cells.
void average_row(const BloomAxis& across, const Area& tile, const std::uint64_t* sums, const CellArea& cells,
                 std::uint64_t* to) {
  for (int i = 0; i < cells.width; ++i, to += 3) {
    const auto cell = static_cast<std::size_t>(cells.x + i);
    const int first = across.first[cell], end = first + static_cast<int>(across.begin[cell + 1] - across.begin[cell]);
    const int from = std::max(first, tile.x), until = std::min(end, tile.x + tile.width);
    const std::uint32_t* weight = across.weights.data() + across.begin[cell] + (from - first);
    std::uint64_t red = 0, green = 0, blue = 0;
    const std::uint64_t* lane = sums + 3 * (from - tile.x);
    for (int x = from; x < until; ++x, ++weight, lane += 3) {
      red += lane[0] * *weight;
      green += lane[1] * *weight;
      blue += lane[2] * *weight;
    }
    to[0] = red;
    to[1] = green;
    to[2] = blue;
  }
}

}  // namespace

void BloomTiles::begin(const View& view, std::vector<Area> tiles, int threads) {
  plan_.make(view.width, view.height, view.bloom);
  tiles_.clear();
  std::size_t averages = 0;
  for (const Area& area : tiles) {
    tiles_.push_back({area, plan_.cells(area), averages});
    averages += tiles_.back().cells.lanes();
  }
  light_.resize(tiles_.size() * kTileLanes);
  averages_.resize(averages);
  rows_.resize(std::max(rows_.size(), static_cast<std::size_t>(threads)));
}

std::uint32_t* BloomTiles::light(std::size_t tile) { return light_.data() + tile * kTileLanes; }

std::span<const std::uint64_t> BloomTiles::averages(std::size_t tile) const {
  return {averages_.data() + tiles_[tile].averages, tiles_[tile].cells.lanes()};
}

void BloomTiles::keep(std::size_t tile, const TileLight& light_of_tile, std::size_t worker) {
  const auto& [area, cells, first_average] = tiles_[tile];
  light_of_tile.copy_to(light(tile), kRowLanes);
  const BloomAxis& down = plan_.levels[0].down;
  std::vector<std::uint64_t>& sums = rows_[worker].sums;
  const std::size_t lanes = static_cast<std::size_t>(area.width) * 3;
  std::uint64_t* to = averages_.data() + first_average;
  for (int row = 0; row < cells.height; ++row, to += cells.row_lanes()) {
    const auto cell = static_cast<std::size_t>(cells.y + row);
    const int first = down.first[cell], end = first + static_cast<int>(down.begin[cell + 1] - down.begin[cell]);
    sums.assign(lanes, 0);
    for (int y = std::max(first, area.y); y < std::min(end, area.y + area.height); ++y) {
      const std::uint32_t weight = down.weights[down.begin[cell] + static_cast<std::size_t>(y - first)];
      kernels_->add(sums.data(), light_of_tile.row(y - area.y), weight, lanes);
    }
    average_row(plan_.levels[0].across, area, sums.data(), cells, to);
  }
}

TileLight BloomTiles::mix(std::size_t tile, const BloomCells& cells, std::size_t worker) {
  const Area& area = tiles_[tile].area;
  const std::size_t lanes = static_cast<std::size_t>(area.width) * 3;
  std::uint32_t* first = light(tile);
  enlarge(*kernels_, plan_.levels[0], cells, area, rows_[worker].glow, [&](int y, GlowRows& rows) {
    std::uint32_t* row = first + static_cast<std::size_t>(y - area.y) * kRowLanes;
    kernels_->mix(row, rows.glow.data(), rows.step.data(), plan_.part, BetweenLanes::kBits + BloomPlan::kFraction,
                  lanes);
  });
  return {first, kRowLanes, area.width, area.height, area.x, area.y};
}

}  // namespace motes::image
