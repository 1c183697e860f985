#include <algorithm>
#include <cstring>

#include "image/layout.h"
#include "image/sort_tiles.h"
#include "particles/memory.h"

namespace motes::image {
namespace {

template <bool kOneColor, bool kDepth, bool kVelocity>
void scatter(const ProjectedBatch& batch, std::size_t count, std::uint32_t* cursor, const FurtherTile* further,
             std::size_t listed, std::byte* records) {
  constexpr std::size_t kBytes = (kDepth ? sizeof(DeepRecord) : sizeof(PlainRecord)) + (kVelocity ? kVelocityBytes : 0);
  const ProjectedBatch b = batch;  // a copy whose members the stores below cannot change
  const std::uint64_t color_of_all = std::uint64_t{b.color[0]} << 32;
  const auto put = [&](std::size_t i, std::size_t tile) {
    std::byte* to = records + cursor[tile]++ * kBytes;
    const std::uint64_t head = b.position[i] | (kOneColor ? color_of_all : std::uint64_t{b.color[i]} << 32);
    std::memcpy(to, &head, sizeof head);
    if (kDepth) std::memcpy(to + 8, b.depth + i, 4);
    if (kVelocity) {
      for (std::size_t c = 0; c < 3; ++c) std::memcpy(to + 12 + 4 * c, b.velocity + c * b.velocity_stride + i, 4);
    }
  };
  for (std::size_t i = 0; i < count; ++i) put(i, b.tile[i]);
  for (std::size_t k = 0; k < listed; ++k) put(further[k].particle, further[k].tile);
}

template <bool kOneColor, class... Arguments>
void scatter_any(const ProjectedBatch& batch, const Arguments&... arguments) {
  if (batch.velocity != nullptr) {
    scatter<kOneColor, true, true>(batch, arguments...);
  } else if (batch.depth != nullptr) {
    scatter<kOneColor, true, false>(batch, arguments...);
  } else {
    scatter<kOneColor, false, false>(batch, arguments...);
  }
}

}  // namespace

std::size_t count_fixed(const ProjectedBatch& b, const ProjectedCount& number, std::size_t columns,
                        std::uint32_t* counts, FurtherTile* further, const std::byte* records,
                        std::size_t record_bytes) {
  for (std::size_t first = 0; first < number.visible; first += kAskedAtOnce) {
    particles::prefetch_for_write(records + first * record_bytes, kAskedAtOnce * record_bytes);
    const std::size_t end = std::min(first + kAskedAtOnce, number.visible);
    for (std::size_t i = first; i < end; ++i) ++counts[b.tile[i]];
  }
  FurtherTile* end = further;
  for (std::size_t k = 0; k < number.several; ++k) {
    const std::uint32_t word = b.several[k], i = word & kBesideFlags;
    end = list_further(end, i, b.tile[i], word, static_cast<std::uint32_t>(columns));
  }
  for (const FurtherTile* one = further; one != end; ++one) ++counts[one->tile];
  return static_cast<std::size_t>(end - further);
}

void scatter_fixed(const ProjectedBatch& batch, bool one_color, std::size_t count, std::uint32_t* cursor,
                   const FurtherTile* further, std::size_t listed, std::byte* records) {
  one_color ? scatter_any<true>(batch, count, cursor, further, listed, records)
            : scatter_any<false>(batch, count, cursor, further, listed, records);
}

}  // namespace motes::image
