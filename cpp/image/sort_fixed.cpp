#include <cstring>

#include "image/layout.h"
#include "image/sort_tiles.h"

namespace motes::image {
namespace {

template <bool kOneColor, bool kDepth, bool kVelocity>
void scatter(const ProjectedBatch& batch, std::size_t count, std::uint32_t* cursor,
             std::span<const FurtherTile> further, std::byte* records) {
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
  for (const FurtherTile& one : further) put(one.particle, one.tile);
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

void scatter_fixed(const ProjectedBatch& batch, bool one_color, std::size_t count, std::uint32_t* cursor,
                   std::span<const FurtherTile> further, std::byte* records) {
  one_color ? scatter_any<true>(batch, count, cursor, further, records)
            : scatter_any<false>(batch, count, cursor, further, records);
}

}  // namespace motes::image
