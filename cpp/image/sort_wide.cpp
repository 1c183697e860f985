#include <cstring>

#include "image/grid.h"
#include "image/layout.h"
#include "image/sort_tiles.h"

namespace motes::image {
namespace {

constexpr std::int64_t kUnit = 1 << kWideBits;

WideRecord record_at(const WideBatch& b, std::size_t i) {
  WideRecord record;
  std::memcpy(&record, b.records + i * (sizeof record / 4), sizeof record);
  return record;
}

// Whether a streak comes near a tile: its bounding box may hold many tiles that a slanting streak never touches.
class Streak {
 public:
  Streak(const WideRecord& r, const Grid& grid)
      : dx_(r.dx), dy_(r.dy), x_(static_cast<double>(r.x + grid.width * kUnit / 2)),
        y_(static_cast<double>(r.y + grid.height * kUnit / 2)) {
    // From the middle of a tile to its corner, then as far as a sprite turned by half a right angle reaches.
    const double radius = static_cast<double>(r.size) * (kUnit >> (kSizeBits + 1)) * 1.4143;
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

// The tiles of a particle that touches several.
template <class Use>
void for_each_tile(const WideBatch& b, std::size_t i, const Grid& grid, const Use& use) {
  const auto columns = static_cast<std::size_t>(grid.columns());
  const WideRecord record = record_at(b, i);
  if (record.dx == 0 || record.dy == 0) {
    return for_each_tile(b.first_tile[i], b.last_tile[i], columns, use, [](auto, auto) { return true; });
  }
  const Streak streak(record, grid);
  for_each_tile(b.first_tile[i], b.last_tile[i], columns, use,
                [&](auto column, auto row) { return streak.near(column, row); });
}

std::size_t first_tile(const WideBatch& b, std::size_t i, std::size_t columns) {
  return (b.first_tile[i] >> 16) * columns + (b.first_tile[i] & 0xffffu);
}

template <bool kVelocity>
void scatter(const WideBatch b, std::size_t count, const Grid grid, std::uint32_t* cursor, const std::uint32_t* several,
             std::size_t listed, std::byte* records) {
  constexpr std::size_t kBytes = sizeof(WideRecord) + (kVelocity ? kVelocityBytes : 0);
  const auto put = [&](std::size_t i, std::byte* to) {
    std::memcpy(to, b.records + i * (sizeof(WideRecord) / 4), sizeof(WideRecord));
    for (std::size_t c = 0; kVelocity && c < 3; ++c) {
      std::memcpy(to + sizeof(WideRecord) + 4 * c, b.velocity + c * b.velocity_stride + i, 4);
    }
  };
  const auto columns = static_cast<std::size_t>(grid.columns());
  std::byte nowhere[kBytes];
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t tile = first_tile(b, i, columns);
    const bool alone = b.first_tile[i] == b.last_tile[i];
    put(i, alone ? records + cursor[tile] * kBytes : nowhere);
    cursor[tile] += alone;
  }
  for (std::size_t k = 0; k < listed; ++k) {
    for_each_tile(b, several[k], grid, [&](std::size_t tile) { put(several[k], records + cursor[tile]++ * kBytes); });
  }
}

}  // namespace

// Particles in one tile are counted free of branches, as those of fixed size are.
std::size_t count_wide(const WideBatch& b, std::size_t count, const Grid& grid, std::uint32_t* counts,
                       std::uint32_t* several) {
  const auto columns = static_cast<std::size_t>(grid.columns());
  std::size_t listed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool alone = b.first_tile[i] == b.last_tile[i];
    counts[first_tile(b, i, columns)] += alone;
    several[listed] = static_cast<std::uint32_t>(i);
    listed += !alone;
  }
  for (std::size_t k = 0; k < listed; ++k) {
    for_each_tile(b, several[k], grid, [&](std::size_t tile) { ++counts[tile]; });
  }
  return listed;
}

void scatter_wide(const WideBatch& b, std::size_t count, const Grid& grid, std::uint32_t* cursor,
                  const std::uint32_t* several, std::size_t listed, std::byte* records) {
  if (b.velocity != nullptr) {
    scatter<true>(b, count, grid, cursor, several, listed, records);
  } else {
    scatter<false>(b, count, grid, cursor, several, listed, records);
  }
}

}  // namespace motes::image
