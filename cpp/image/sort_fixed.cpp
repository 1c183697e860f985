#include <cstring>

#include "image/layout.h"
#include "image/sort_tiles.h"

namespace motes::image {
namespace {

template <bool kDepth, bool kVelocity>
void scatter(const ProjectedBatch& b, std::size_t count, std::size_t columns, std::uint32_t* cursor,
             const std::uint32_t* several, std::size_t listed, std::byte* records) {
  constexpr std::size_t kBytes = (kDepth ? sizeof(DeepRecord) : sizeof(PlainRecord)) + (kVelocity ? kVelocityBytes : 0);
  const auto put = [&](std::size_t i, std::byte* to) {
    std::memcpy(to, b.position + i, 4);
    std::memcpy(to + 4, b.color + i, 4);
    if (kDepth) std::memcpy(to + 8, b.depth + i, 4);
    if (kVelocity) {
      for (std::size_t c = 0; c < 3; ++c) std::memcpy(to + 12 + 4 * c, b.velocity + c * b.velocity_stride + i, 4);
    }
  };
  for (std::size_t i = 0; i < count; ++i) put(i, records + cursor[b.tile[i] & kTileNumber]++ * kBytes);
  std::byte nowhere[kBytes];
  const auto put_if = [&](std::size_t i, std::size_t tile, std::uint32_t wanted) {
    put(i, wanted != 0 ? records + cursor[tile] * kBytes : nowhere);
    cursor[tile] += wanted;
  };
  for (std::size_t k = 0; k < listed; ++k) {
    const std::uint32_t i = several[k];
    const std::uint32_t column = b.tile[i] >> 30 & 1, row = b.tile[i] >> 31;
    const std::size_t tile = b.tile[i] & kTileNumber;
    put_if(i, tile + 1, column);
    put_if(i, tile + columns, row);
    put_if(i, tile + columns + 1, column & row);
  }
}

}  // namespace

// Free of branches: which particles touch several tiles is random, and a misprediction costs more than the work.
std::size_t count_fixed(const ProjectedBatch& b, std::size_t count, std::size_t columns, std::uint32_t* counts,
                        std::uint32_t* several) {
  std::size_t listed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    ++counts[b.tile[i] & kTileNumber];
    several[listed] = static_cast<std::uint32_t>(i);
    listed += b.tile[i] > kTileNumber;
  }
  for (std::size_t k = 0; k < listed; ++k) {
    const std::uint32_t word = b.tile[several[k]];
    const std::uint32_t column = word >> 30 & 1, row = word >> 31;
    std::uint32_t* tile = counts + (word & kTileNumber);
    tile[1] += column;
    tile[columns] += row;
    tile[columns + 1] += column & row;
  }
  return listed;
}

void scatter_fixed(const ProjectedBatch& batch, std::size_t count, std::size_t columns, std::uint32_t* cursor,
                   const std::uint32_t* several, std::size_t listed, std::byte* records) {
  if (batch.velocity != nullptr) {
    scatter<true, true>(batch, count, columns, cursor, several, listed, records);
  } else if (batch.depth != nullptr) {
    scatter<true, false>(batch, count, columns, cursor, several, listed, records);
  } else {
    scatter<false, false>(batch, count, columns, cursor, several, listed, records);
  }
}

}  // namespace motes::image
