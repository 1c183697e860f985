// The order of a tile's records from far to near, whatever the range of their depths and the number of records.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "image/raster/ordered.h"
#include "image/raster/pieces.h"
#include "image/test_image_scene.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_image_ordered {
using namespace image_test;

namespace {

constexpr std::size_t kBytes = sizeof(DeepRecord);

DeepRecord record_at(const std::byte* from) {
  DeepRecord record;
  std::memcpy(&record, from, kBytes);
  return record;
}

// Sorts records into the promised order, only by comparing them.
std::vector<std::byte> sorted(const std::vector<std::byte>& records) {
  std::vector<const std::byte*> order;
  for (std::size_t at = 0; at < records.size(); at += kBytes) order.push_back(records.data() + at);
  std::sort(order.begin(), order.end(), [](const std::byte* a, const std::byte* b) {
    const auto first = record_at(a).depth, second = record_at(b).depth;
    return first != second ? first > second : std::memcmp(a, b, kBytes) < 0;
  });
  std::vector<std::byte> all;
  for (const std::byte* one : order) all.insert(all.end(), one, one + kBytes);
  return all;
}

}  // namespace

TEST(image_records_are_ordered_from_far_to_near) {
  const View view = small_view();
  Sprite sprite;
  sprite.blend = Sprite::Blend::alpha;
  const Brush brush(sprite, Layout::deep, view);
  test::Dice dice(77);
  Ordered ordered;
  for (const std::size_t count : {0u, 1u, 2u, 100u, 255u, 256u, 300u, 5000u}) {
    for (int bits = 0; bits <= 30; ++bits) {  // of the range of depths
      std::vector<std::byte> records(count * kBytes);
      for (std::byte& b : records) b = static_cast<std::byte>(dice.below(256));
      const auto least = static_cast<std::uint32_t>(dice.below((1u << 30) + 1));
      for (std::size_t i = 0; i < count; ++i) {
        const auto depth = least + static_cast<std::uint32_t>(dice.below(std::uint64_t{1} << bits));
        std::memcpy(records.data() + i * kBytes + offsetof(DeepRecord, depth), &depth, sizeof depth);
      }
      const std::size_t cut = count / 3;
      const Piece pieces[] = {{&brush, records.data() + cut * kBytes, count - cut, 9},
                              {&brush, records.data(), cut, 7}};
      ordered.sort(pieces);
      CHECK(ordered.runs().size() == (count == 0 ? 0 : 1));
      if (count == 0) continue;
      const Piece& run = ordered.runs().front();
      CHECK(run.brush == &brush && run.count == count && run.most_alpha == 9);
      CHECK(std::memcmp(run.records, sorted(records).data(), records.size()) == 0);
    }
  }
}

// Records of two brushes, of 12 and of 8 bytes: those without a depth are nearer than all others.
TEST(image_records_of_several_brushes_are_ordered_by_depth_brush_and_content) {
  const View view = small_view();
  Sprite small, large;
  small.blend = large.blend = Sprite::Blend::alpha;
  small.pixels = 3;
  const Brush first(small, Layout::deep, view), second(large, Layout::deep, view), flat(large, Layout::plain, view);
  test::Dice dice(78);
  Ordered ordered;
  for (const std::size_t count : {2u, 50u, 400u, 3000u}) {
    struct One {
      const Brush* brush;
      std::vector<std::byte> bytes;
      std::uint32_t depth;
    };
    std::vector<One> all;
    std::vector<std::vector<std::byte>> memory;
    std::vector<Piece> pieces;
    for (const Brush* brush : {&first, &second, &flat, &first}) {
      std::vector<std::byte> records(count * brush->record_bytes());
      for (std::byte& b : records) b = static_cast<std::byte>(dice.below(3));
      for (std::size_t i = 0; i < count; ++i) {
        std::byte* record = records.data() + i * brush->record_bytes();
        const auto depth = 0x41000000u + static_cast<std::uint32_t>(dice.below(40));  // often the same
        if (brush != &flat) std::memcpy(record + offsetof(DeepRecord, depth), &depth, sizeof depth);
        all.push_back({brush, {record, record + brush->record_bytes()}, brush == &flat ? 0 : depth});
      }
      memory.push_back(std::move(records));
      pieces.push_back({brush, memory.back().data(), count, 5});
    }
    std::sort(all.begin(), all.end(), [](const One& a, const One& b) {
      if (a.depth != b.depth) return a.depth > b.depth;
      if (a.brush != b.brush) return *a.brush < *b.brush;
      return std::memcmp(a.bytes.data(), b.bytes.data(), a.bytes.size()) < 0;
    });
    ordered.sort(pieces);
    std::size_t i = 0;
    for (const Piece& run : ordered.runs()) {
      const std::byte* record = run.records;
      for (std::size_t k = 0; k < run.count && i < all.size(); ++k, ++i, record += run.brush->record_bytes()) {
        CHECK(run.brush == all[i].brush && std::memcmp(record, all[i].bytes.data(), all[i].bytes.size()) == 0);
      }
    }
    CHECK(i == all.size());
  }
}

}  // namespace motes::test_image_ordered
