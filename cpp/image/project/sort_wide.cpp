#include <algorithm>
#include <cstring>

#include "image/grid.h"
#include "image/layout.h"
#include "image/project/sort_tiles.h"

namespace motes::image {
namespace {

constexpr std::int64_t kPixel = 1 << kWideBits;

// Tests whether a streak comes near a tile: the bounding box of a slanted streak may contain many tiles that it does
// not touch.
class Streak {
 public:
  Streak(const WideRecord& r, const Grid& grid)
      : dx_(r.dx), dy_(r.dy), x_(static_cast<double>(r.x + grid.width * kPixel / 2)),
        y_(static_cast<double>(r.y + grid.height * kPixel / 2)) {
    // The distance from the middle of a tile to its corner, plus the reach of a sprite turned by 45 degrees.
    const double radius = static_cast<double>(size_units(r.size)) * (kPixel >> (kSizeBits + 1)) * 1.4143;
    const double reach = (kTile / 2 * 1.4143 + 1) * static_cast<double>(kPixel) + radius;
    reach_square_ = reach * reach * (dx_ * dx_ + dy_ * dy_);
  }
  bool near(std::uint32_t column, std::uint32_t row) const {
    const double across = (column + 0.5) * static_cast<double>(kTile * kPixel) - x_;
    const double down = (row + 0.5) * static_cast<double>(kTile * kPixel) - y_;
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

// Copies the words of a record from a batch: see fours_of(). Always inlined: a known number of words needs no loop.
__attribute__((always_inline)) inline void copy_words(const WideBatch& b, std::size_t words, std::size_t i,
                                                      std::byte* to) {
  std::size_t w = 0;
  for (; w < kFour * fours_of(words); w += kFour) {
    std::memcpy(to + 4 * w, b.words + w * b.stride + kFour * i, 4 * std::min(words - w, kFour));
  }
  for (; w < words; ++w) std::memcpy(to + 4 * w, b.words + w * b.stride + i, 4);
}

WideRecord record_at(const WideBatch& b, std::size_t i, const RecordForm& form, const Grid& grid) {
  std::byte bytes[image::form(Layout::posed_tiled).bytes];
  copy_words(b, static_cast<std::size_t>(form.bytes) / 4, i, bytes);
  return wide_record(form, grid.far_bits(), bytes);
}

// Calls use(tile) for each tile of a particle that touches many, except the one that b.tile holds.
template <class Use>
void for_each_other(const WideBatch& b, const ManyTiles& many, const RecordForm& form, const Grid& grid,
                    const Use& use) {
  const std::size_t own = b.tile[many.particle];
  const auto others = [&](std::size_t tile) {
    if (tile != own) use(tile);
  };
  const auto columns = static_cast<std::size_t>(grid.columns());
  const WideRecord record = record_at(b, many.particle, form, grid);
  const bool posed = form.bytes >= static_cast<int>(sizeof(PosedRecord));  // these may reach farther than their size
  if (posed || b.boxes || form.way == 0 || record.dx == 0 || record.dy == 0) {
    return for_each_tile(many.first, many.last, columns, others, [](auto, auto) { return true; });
  }
  const Streak streak(record, grid);
  for_each_tile(many.first, many.last, columns, others,
                [&](auto column, auto row) { return streak.near(column, row); });
}

template <std::size_t kWords, bool kVelocity>
void scatter(const WideBatch& batch, std::size_t count, std::uint32_t* cursor, std::span<const FurtherTile> further,
             std::byte* records) {
  constexpr std::size_t kBytes = 4 * kWords + (kVelocity ? kVelocityBytes : 0);
  const WideBatch b = batch;  // a copy whose members the stores below cannot change
  const auto put = [&](std::size_t i, std::size_t tile) {
    std::byte* to = records + cursor[tile]++ * kBytes;
    copy_words(b, kWords, i, to);
    for (std::size_t c = 0; kVelocity && c < 3; ++c) {
      std::memcpy(to + 4 * (kWords + c), b.velocity + c * b.stride + i, 4);
    }
  };
  for (std::size_t i = 0; i < count; ++i) put(i, b.tile[i]);
  for (const FurtherTile& one : further) put(one.particle, one.tile);
}

template <bool kVelocity, class... Arguments>
void scatter_words(std::size_t words, const Arguments&... arguments) {
  switch (words) {
    case 2: return scatter<2, kVelocity>(arguments...);
    case 3: return scatter<3, kVelocity>(arguments...);
    case 4: return scatter<4, kVelocity>(arguments...);
    case 5: return scatter<5, kVelocity>(arguments...);
    case 9: return scatter<9, kVelocity>(arguments...);
    case 11: return scatter<11, kVelocity>(arguments...);
    case 12: return scatter<12, kVelocity>(arguments...);
    default: return scatter<8, kVelocity>(arguments...);
  }
}

}  // namespace

void count_many(const WideBatch& batch, std::size_t many, const RecordForm& form, const Grid& grid,
                std::uint32_t* counts, FurtherTiles& further) {
  for (std::size_t k = 0; k < many; ++k) {
    for_each_other(batch, batch.many[k], form, grid, [&](std::size_t tile) {
      further.add(batch.many[k].particle, tile);
      ++counts[tile];
    });
  }
}

void scatter_wide(const WideBatch& batch, std::size_t count, std::size_t words, std::uint32_t* cursor,
                  std::span<const FurtherTile> further, std::byte* records) {
  if (batch.velocity != nullptr) {
    scatter_words<true>(words, batch, count, cursor, further, records);
  } else {
    scatter_words<false>(words, batch, count, cursor, further, records);
  }
}

}  // namespace motes::image
