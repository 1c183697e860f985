#include <cstring>

#include "image/layout.h"
#include "image/project/sort_tiles.h"

namespace motes::image {
namespace {

template <Colors kColors, bool kDepth, bool kVelocity>
void scatter(const ProjectedBatch& batch, std::size_t count, std::uint32_t* cursor,
             std::span<const FurtherTile> further, std::byte* records) {
  constexpr std::size_t kColorless = kDepth ? 8 : 4, kStill = kColorless + (kColors == Colors::none ? 0 : 4);
  constexpr std::size_t kBytes = kStill + (kVelocity ? kVelocityBytes : 0);
  const ProjectedBatch b = batch;  // a copy whose members the stores below cannot change
  const std::uint64_t color_of_all = std::uint64_t{b.color[0]} << 32;
  const auto put = [&](std::size_t i, std::size_t tile) {
    std::byte* to = records + cursor[tile]++ * kBytes;
    std::uint64_t head = b.position[i];
    if (kColors == Colors::none && kDepth) head |= std::uint64_t{b.depth[i]} << 32;
    if (kColors == Colors::same) head |= color_of_all;
    if (kColors == Colors::each) head |= std::uint64_t{b.color[i]} << 32;
    std::memcpy(to, &head, kStill < sizeof head ? kStill : sizeof head);
    if (kStill > sizeof head) std::memcpy(to + sizeof head, b.depth + i, 4);
    if (kVelocity) {
      for (std::size_t c = 0; c < 3; ++c) std::memcpy(to + kStill + 4 * c, b.velocity + c * b.velocity_stride + i, 4);
    }
  };
  for (std::size_t i = 0; i < count; ++i) put(i, b.tile[i]);
  for (const FurtherTile& one : further) put(one.particle, one.tile);
}

template <Colors kColors, class... Arguments>
void scatter_any(const ProjectedBatch& batch, const Arguments&... arguments) {
  if (batch.velocity != nullptr) {
    scatter<kColors, true, true>(batch, arguments...);
  } else if (batch.depth != nullptr) {
    scatter<kColors, true, false>(batch, arguments...);
  } else {
    scatter<kColors, false, false>(batch, arguments...);
  }
}

}  // namespace

void scatter_fixed(const ProjectedBatch& batch, Colors colors, std::size_t count, std::uint32_t* cursor,
                   std::span<const FurtherTile> further, std::byte* records) {
  switch (colors) {
    case Colors::none: return scatter_any<Colors::none>(batch, count, cursor, further, records);
    case Colors::same: return scatter_any<Colors::same>(batch, count, cursor, further, records);
    case Colors::each: return scatter_any<Colors::each>(batch, count, cursor, further, records);
  }
}

}  // namespace motes::image
