#include "image/partial_tile.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace motes::image {
namespace {

constexpr std::uint32_t kMagic = 0x3154504d;  // "MPT1"

struct Box {
  std::uint8_t left = 0, top = 0, right = 0, bottom = 0;

  std::size_t sums_per_row() const { return 3 * static_cast<std::size_t>(right - left); }
  std::size_t bytes() const { return 4 * sums_per_row() * static_cast<std::size_t>(bottom - top); }
};

struct Header {
  std::uint32_t magic = kMagic;
  std::uint32_t tile = 0;
  Box box;
  std::uint32_t zero = 0;
};
static_assert(sizeof(Header) == 16);

// Empty where there is no light.
Box bounding_box(const Area& area, const std::uint32_t* light, int stride) {
  int left = area.width, right = 0, top = area.height, bottom = 0;
  for (int y = 0; y < area.height; ++y) {
    const std::uint32_t* row = light + static_cast<std::ptrdiff_t>(y) * stride;
    const std::uint32_t* end = row + static_cast<std::ptrdiff_t>(3) * area.width;
    const std::uint32_t* first = std::find_if(row, end, [](std::uint32_t sum) { return sum != 0; });
    if (first == end) continue;
    while (end[-1] == 0) --end;
    left = std::min(left, static_cast<int>(first - row) / 3);
    right = std::max(right, static_cast<int>(end - 1 - row) / 3 + 1);
    top = std::min(top, y);
    bottom = y + 1;
  }
  if (right == 0) return {};
  const auto byte = [](int v) { return static_cast<std::uint8_t>(v); };
  return {byte(left), byte(top), byte(right), byte(bottom)};
}

}  // namespace

void append_partial(const Area& area, const std::uint32_t* light, int stride, Buffer& to) {
  Header header;
  header.tile = static_cast<std::uint32_t>(area.tile);
  header.box = bounding_box(area, light, stride);
  const std::size_t at = to.size();
  to.resize(at + sizeof header + header.box.bytes());
  std::byte* out = to.data() + at;
  std::memcpy(out, &header, sizeof header);
  out += sizeof header;
  const std::size_t row_bytes = 4 * header.box.sums_per_row();
  for (int y = header.box.top; y < header.box.bottom; ++y, out += row_bytes) {
    std::memcpy(out, light + static_cast<std::ptrdiff_t>(y) * stride + 3 * header.box.left, row_bytes);
  }
}

void add_partial(std::span<const std::byte> partial, const Area& area, std::uint32_t* light, int stride) {
  Header header;
  if (partial.size() < sizeof header) throw std::runtime_error("partial tile: message is too short");
  std::memcpy(&header, partial.data(), sizeof header);
  const Box& box = header.box;
  if (header.magic != kMagic) throw std::runtime_error("partial tile: not a message of a partial tile");
  if (header.tile != static_cast<std::uint32_t>(area.tile) || box.left > box.right || box.top > box.bottom ||
      box.right > area.width || box.bottom > area.height) {
    throw std::runtime_error("partial tile: of another tile");
  }
  if (partial.size() != sizeof header + box.bytes()) throw std::runtime_error("partial tile: sizes do not agree");
  const std::byte* in = partial.data() + sizeof header;
  for (int y = box.top; y < box.bottom; ++y) {
    std::uint32_t* row = light + static_cast<std::ptrdiff_t>(y) * stride + 3 * box.left;
    std::uint32_t more[3 * kTile];
    std::memcpy(more, in, 4 * box.sums_per_row());
    for (std::size_t i = 0; i < box.sums_per_row(); ++i) {
      const std::uint32_t sum = row[i] + more[i];
      row[i] = sum < more[i] ? 0xffffffffu : sum;
    }
    in += 4 * box.sums_per_row();
  }
}

}  // namespace motes::image
