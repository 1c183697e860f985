// The order of a tile's records from far to near, whatever the range of their depths and the number of records.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "check.h"
#include "image/ordered.h"
#include "image/pieces.h"
#include "isas.h"
#include "test_image_scene.h"

using namespace image_test;

namespace {

constexpr std::size_t kBytes = sizeof(DeepRecord);

DeepRecord record_at(const std::byte* from) {
  DeepRecord record;
  std::memcpy(&record, from, kBytes);
  return record;
}

// In the order that is promised, by comparing alone.
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
