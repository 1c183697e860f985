#include <cstring>

#include "image/layout.h"
#include "image/sort_tiles.h"

namespace motes::image {
namespace {

template <bool kDepth, bool kVelocity>
void scatter(const ProjectedBatch& b, std::size_t count, std::uint32_t* cursor, const FurtherTile* further,
             std::size_t listed, std::byte* records) {
  constexpr std::size_t kBytes = (kDepth ? sizeof(DeepRecord) : sizeof(PlainRecord)) + (kVelocity ? kVelocityBytes : 0);
  const auto put = [&](std::size_t i, std::size_t tile) {
    std::byte* to = records + cursor[tile]++ * kBytes;
    std::memcpy(to, b.head + 2 * i, 8);
    if (kDepth) std::memcpy(to + 8, b.depth + i, 4);
    if (kVelocity) {
      for (std::size_t c = 0; c < 3; ++c) std::memcpy(to + 12 + 4 * c, b.velocity + c * b.velocity_stride + i, 4);
    }
  };
  for (std::size_t i = 0; i < count; ++i) put(i, b.tile[i] & kTileNumber);
  for (std::size_t k = 0; k < listed; ++k) put(further[k].particle, further[k].tile);
}

}  // namespace

std::size_t count_fixed(const ProjectedBatch& b, const ProjectedCount& number, std::size_t columns,
                        std::uint32_t* counts, FurtherTile* further) {
  for (std::size_t i = 0; i < number.visible; ++i) ++counts[b.tile[i] & kTileNumber];
  FurtherTile* end = further;
  for (std::size_t k = 0; k < number.several; ++k) {
    const std::uint32_t i = b.several[k], word = b.tile[i];
    end = list_further(end, i, word & kTileNumber, word, static_cast<std::uint32_t>(columns));
  }
  for (const FurtherTile* one = further; one != end; ++one) ++counts[one->tile];
  return static_cast<std::size_t>(end - further);
}

void scatter_fixed(const ProjectedBatch& batch, std::size_t count, std::uint32_t* cursor, const FurtherTile* further,
                   std::size_t listed, std::byte* records) {
  if (batch.velocity != nullptr) {
    scatter<true, true>(batch, count, cursor, further, listed, records);
  } else if (batch.depth != nullptr) {
    scatter<true, false>(batch, count, cursor, further, listed, records);
  } else {
    scatter<false, false>(batch, count, cursor, further, listed, records);
  }
}

}  // namespace motes::image
