#include "base/hash.h"

#include <algorithm>
#include <cstring>

namespace motes::base {

Hash hash(std::span<const std::byte> bytes) {
  Hash h{kGolden, bytes.size()};
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    h.low = mix(h.low ^ word) + kGolden;
    h.high = mix(h.high + word * 0xd6e8feb86659fd93u) ^ h.low;
  }
  return {mix(h.low), mix(h.high)};
}

}  // namespace motes::base
