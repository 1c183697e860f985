#include "particles/touches.h"

#include <algorithm>
#include <stdexcept>

namespace motes::particles {

void TouchMemory::set(Row& row, std::span<const Touch> touches) {
  const auto count = static_cast<std::uint32_t>(touches.size());
  if (count > row.room) {
    const std::uint32_t room = (count + 3) / 4 * 4;  // room to spare: touches come and go
    if (all_.size() + room > UINT32_MAX) throw std::length_error("more than 4294967295 touches on one rank");
    row.first = static_cast<std::uint32_t>(all_.size());
    row.room = room;
    all_.resize(all_.size() + room);
  }
  row.count = count;
  std::copy(touches.begin(), touches.end(), all_.begin() + row.first);
}

void TouchMemory::tidy(std::span<Row> rows) {
  std::size_t used = 0;
  for (const Row& row : rows) used += row.room;
  if (all_.size() <= 2 * used + 1024) return;
  std::vector<Touch> kept;
  kept.reserve(used);
  for (Row& row : rows) {
    const auto first = static_cast<std::uint32_t>(kept.size());
    kept.insert(kept.end(), all_.begin() + row.first, all_.begin() + row.first + row.count);
    row.first = first;
    row.room = row.count;
  }
  all_ = std::move(kept);
}

}  // namespace motes::particles
