#include "image/project/sort_tiles.h"

#include <algorithm>

#include "base/memory.h"

namespace motes::image {

void count_tiles(const Touched& touched, std::uint32_t* counts, FurtherTiles& further, const std::byte* records,
                 std::size_t record_bytes) {
  const Touched t = touched;
  for (std::size_t first = 0; first < t.visible; first += kAskedAtOnce) {
    base::prefetch_for_write(records + first * record_bytes, kAskedAtOnce * record_bytes);
    const std::size_t end = std::min(first + kAskedAtOnce, t.visible);
    for (std::size_t i = first; i < end; ++i) ++counts[t.tile[i]];
  }
  further.clear(t.several_count);
  for (std::size_t k = 0; k < t.several_count; ++k) {
    const std::uint32_t word = t.several[k], i = word & kNumberMask;
    further.add_up_to_three(i, t.tile[i], word, static_cast<std::uint32_t>(t.columns));
  }
  for (const FurtherTile& one : further.all()) ++counts[one.tile];
}

}  // namespace motes::image
