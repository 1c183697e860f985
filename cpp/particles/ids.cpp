#include "particles/ids.h"

#include <algorithm>

namespace motes::particles {

void join(const Ids& ids, std::size_t count, std::uint64_t* whole) {
  if (ids.upper == nullptr) {
    std::copy_n(ids.lower, count, whole);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) whole[i] = std::uint64_t{ids.upper[i]} << 32 | ids.lower[i];
}

IdList::IdList(std::span<const std::uint64_t> ids) : lower_(ids.size()) {
  std::transform(ids.begin(), ids.end(), lower_.begin(), lower_half);
  if (std::none_of(ids.begin(), ids.end(), upper_half)) return;
  upper_.resize(lower_.size());
  std::transform(ids.begin(), ids.end(), upper_.begin(), upper_half);
}

}  // namespace motes::particles
