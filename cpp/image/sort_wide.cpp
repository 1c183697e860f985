#include <cstring>

#include "image/grid.h"
#include "image/layout.h"
#include "image/sort_tiles.h"

namespace motes::image {
namespace {

constexpr std::int64_t kUnit = 1 << kWideBits;

std::int64_t signed_word(std::uint32_t word) { return static_cast<std::int32_t>(word); }

// Whether a streak comes near a tile: its bounding box may hold many tiles that a slanting streak never touches.
class Streak {
 public:
  Streak(const WideBatch& b, std::size_t i, const Grid& grid)
      : dx_(static_cast<double>(signed_word(b.dx[i]))), dy_(static_cast<double>(signed_word(b.dy[i]))),
        x_(static_cast<double>(signed_word(b.x[i]) + grid.width * kUnit / 2)),
        y_(static_cast<double>(signed_word(b.y[i]) + grid.height * kUnit / 2)) {
    // From the middle of a tile to its corner, then as far as a sprite turned by half a right angle reaches.
    const double radius = static_cast<double>(b.size[i] & 0xffffu) * (kUnit >> (kSizeBits + 1)) * 1.4143;
    const double reach = (kTile / 2 * 1.4143 + 1) * static_cast<double>(kUnit) + radius;
    reach_square_ = reach * reach * (dx_ * dx_ + dy_ * dy_);
  }
  bool near(std::uint32_t column, std::uint32_t row) const {
    const double across = (column + 0.5) * static_cast<double>(kTile * kUnit) - x_;
    const double down = (row + 0.5) * static_cast<double>(kTile * kUnit) - y_;
    const double distance = across * dy_ - down * dx_;
    return distance * distance <= reach_square_;
  }

 private:
  double dx_, dy_, x_, y_, reach_square_ = 0;
};

template <class Use, class Wanted>
void for_each_tile(std::uint32_t first, std::uint32_t last, std::size_t columns, const Use& use, const Wanted& wanted) {
  for (std::uint32_t row = first >> 16; row <= last >> 16; ++row) {
    for (std::uint32_t column = first & 0xffffu; column <= (last & 0xffffu); ++column) {
      if (wanted(column, row)) use(row * columns + column);
    }
  }
}

template <class Use>
void for_each_tile(const WideBatch& b, std::size_t i, const Grid& grid, const Use& use) {
  const std::uint32_t first = b.first_tile[i], last = b.last_tile[i];
  const auto columns = static_cast<std::size_t>(grid.columns());
  if (b.dx == nullptr || b.dx[i] == 0 || b.dy[i] == 0 || first == last) {
    return for_each_tile(first, last, columns, use, [](auto, auto) { return true; });
  }
  const Streak streak(b, i, grid);
  for_each_tile(first, last, columns, use, [&](auto column, auto row) { return streak.near(column, row); });
}

}  // namespace

void count_wide(const WideBatch& batch, std::size_t count, const Grid& grid, std::uint32_t* counts) {
  for (std::size_t i = 0; i < count; ++i) {
    for_each_tile(batch, i, grid, [&](std::size_t tile) { ++counts[tile]; });
  }
}

void scatter_wide(const WideBatch& b, std::size_t count, const Grid& grid, std::uint32_t* cursor, std::byte* records) {
  constexpr std::size_t kWords = (sizeof(WideRecord) + kVelocityBytes) / 4;
  const std::size_t bytes = sizeof(WideRecord) + (b.velocity != nullptr ? kVelocityBytes : 0);
  std::uint32_t record[kWords] = {};
  for (std::size_t i = 0; i < count; ++i) {
    record[0] = b.x[i];
    record[1] = b.y[i];
    record[2] = b.color[i];
    record[3] = b.depth[i];
    record[4] = b.size[i];
    if (b.up != nullptr) record[5] = b.up[i];
    if (b.dx != nullptr) {
      record[6] = b.dx[i];
      record[7] = b.dy[i];
    }
    for (std::size_t c = 0; c < 3 && b.velocity != nullptr; ++c) record[8 + c] = b.velocity[c * b.velocity_stride + i];
    for_each_tile(b, i, grid, [&](std::size_t tile) { std::memcpy(records + cursor[tile]++ * bytes, record, bytes); });
  }
}

}  // namespace motes::image
