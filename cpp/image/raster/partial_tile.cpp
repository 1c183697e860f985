#include "image/raster/partial_tile.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace motes::image {
namespace {

constexpr std::uint32_t kMagic = 0x3254504d;  // "MPT2"

struct Header {
  std::uint32_t magic = kMagic;
  std::uint32_t tile = 0;
  PixelBox light, surface;
};
static_assert(sizeof(Header) == 16);

// Returns the bounding box of the pixels for which active(x, y) holds; empty if there are none.
template <class Active>
PixelBox bounding_box(const Area& area, const Active& active) {
  int left = area.width, right = 0, top = area.height, bottom = 0;
  for (int y = 0; y < area.height; ++y) {
    int first = 0, last = area.width - 1;
    while (first < area.width && !active(first, y)) ++first;
    if (first == area.width) continue;
    while (!active(last, y)) --last;
    left = std::min(left, first);
    right = std::max(right, last + 1);
    top = std::min(top, y);
    bottom = y + 1;
  }
  if (right == 0) return {};
  const auto byte = [](int v) { return static_cast<std::uint8_t>(v); };
  return {byte(left), byte(top), byte(right), byte(bottom)};
}

}  // namespace

void append_partial(const Area& area, const TilePlanes& tile, bool surfaces, Buffer& to) {
  Header header;
  header.tile = static_cast<std::uint32_t>(area.tile);
  header.light = bounding_box(area, [&](int x, int y) {
    const std::uint32_t* sums = tile.light + y * kLightStride + 3 * x;
    return (sums[0] | sums[1] | sums[2]) != 0;
  });
  if (surfaces) {
    header.surface = bounding_box(area, [&](int x, int y) {
      const std::ptrdiff_t pixel = y * kPixelStride + x;
      return tile.surfaces[pixel] < no_surface(tile.depth[pixel]);
    });
  }
  const std::size_t at = to.size();
  to.resize(at + sizeof header + 12 * header.light.pixels() + 8 * header.surface.pixels());
  std::byte* out = to.data() + at;
  std::memcpy(out, &header, sizeof header);
  out += sizeof header;
  const std::size_t row_bytes = 12 * header.light.columns();
  for (int y = header.light.top; y < header.light.bottom; ++y, out += row_bytes) {
    std::memcpy(out, tile.light + y * kLightStride + 3 * header.light.left, row_bytes);
  }
  const std::size_t surface_bytes = sizeof(NearestSurface) * header.surface.columns();
  for (int y = header.surface.top; y < header.surface.bottom; ++y, out += surface_bytes) {
    std::memcpy(out, tile.surfaces + y * kPixelStride + header.surface.left, surface_bytes);
  }
}

PartialTile::PartialTile(std::span<const std::byte> bytes, const Area& area) {
  Header header;
  if (bytes.size() < sizeof header) throw std::runtime_error("partial tile: message is too short");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != kMagic) throw std::runtime_error("partial tile: not a message of a partial tile");
  light_box_ = header.light;
  surface_box_ = header.surface;
  if (header.tile != static_cast<std::uint32_t>(area.tile) || !light_box_.inside(area) || !surface_box_.inside(area)) {
    throw std::runtime_error("partial tile: belongs to another tile");
  }
  bytes_ = bytes.subspan(sizeof header);
  if (bytes_.size() != 12 * light_box_.pixels() + 8 * surface_box_.pixels()) {
    throw std::runtime_error("partial tile: sizes do not agree");
  }
}

void PartialTile::add_light(std::uint32_t* light) const {
  const std::size_t numbers = 3 * light_box_.columns();
  const std::byte* in = bytes_.data();
  for (int y = light_box_.top; y < light_box_.bottom; ++y, in += 4 * numbers) {
    std::uint32_t* row = light + y * kLightStride + 3 * light_box_.left;
    std::uint32_t more[3 * kTile];
    std::memcpy(more, in, 4 * numbers);
    for (std::size_t i = 0; i < numbers; ++i) {
      const std::uint32_t sum = row[i] + more[i];
      row[i] = sum < more[i] ? 0xffffffffu : sum;
    }
  }
}

void PartialTile::keep_nearest(NearestSurface* surfaces) const {
  const std::byte* in = bytes_.data() + 12 * light_box_.pixels();
  for (int y = surface_box_.top; y < surface_box_.bottom; ++y) {
    NearestSurface* row = surfaces + y * kPixelStride;
    for (int x = surface_box_.left; x < surface_box_.right; ++x, in += sizeof(NearestSurface)) {
      NearestSurface other;
      std::memcpy(&other, in, sizeof other);
      row[x] = std::min(row[x], other);
    }
  }
}

}  // namespace motes::image
