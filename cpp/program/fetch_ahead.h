// Prefetches columns of the next block while actions compute on the current one.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "particles/store.h"

namespace motes::program {

/// Each run of an action over a block prefetches a part of the next block's cache lines, so that memory answers while
/// the processor computes.
class FetchAhead {
 public:
  /// `attributes`: one bit each; those without planes are skipped. `ids`: whether the list reads them. `runs`: of
  /// actions over a block, in all sub-steps together. `block`: particles, a power of two; 0: nothing is prefetched.
  FetchAhead(const particles::Store& store, std::uint64_t attributes, bool ids, std::size_t runs, std::size_t block)
      : line_bits_(block == 0 ? 0 : std::countr_zero(4 * block / kLine)) {
    if (block == 0) return;
    for (int a = 0; a < store.schema().size(); ++a) {
      if ((attributes >> a & 1u) == 0 || store.uniform(a)) continue;
      for (int c = 0; c < store.schema()[a].width; ++c) planes_.push_back(store.plane(a, c));
    }
    if (ids) planes_.push_back(store.ids().lower);
    if (ids && store.ids().upper != nullptr) planes_.push_back(store.ids().upper);
    part_ = ((planes_.size() << line_bits_) + runs - 1) / std::max(runs, std::size_t{1});
  }

  /// Continues with the block that starts at particle `next`, or with none if that is the end.
  void aim(std::size_t next, std::size_t end) {
    next_ = next;
    line_ = 0;
    lines_ = next < end ? planes_.size() << line_bits_ : 0;
  }

  /// Prefetches the next part.
  void fetch() {
    for (const std::size_t stop = std::min(line_ + part_, lines_); line_ < stop; ++line_) {
      __builtin_prefetch(static_cast<const char*>(planes_[line_ >> line_bits_]) + 4 * next_ +
                         kLine * (line_ & ((std::size_t{1} << line_bits_) - 1)));
    }
  }

  /// Returns how many cache lines of the next block have not been prefetched yet.
  std::size_t left() const { return lines_ - line_; }

 private:
  static constexpr std::size_t kLine = 64;  // bytes

  int line_bits_;  // log2 of the cache lines that a column of a block takes
  std::vector<const void*> planes_;
  std::size_t part_ = 0, next_ = 0, line_ = 0, lines_ = 0;
};

}  // namespace motes::program
