// Philox4x32, counter-based random numbers: J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC11.
#pragma once

#include <array>
#include <cstdint>

#include "particles/streams.h"

namespace motes::particles {

using Words = std::array<std::uint32_t, 4>;

/// Returns four random words. Seven rounds pass TestU01's BigCrush (table 2 of the paper); the authors recommend ten.
constexpr Words philox(Words counter, Key key, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    const std::uint64_t first = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t second = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(second >> 32) ^ counter[1] ^ key.low, static_cast<std::uint32_t>(second),
               static_cast<std::uint32_t>(first >> 32) ^ counter[3] ^ key.high, static_cast<std::uint32_t>(first)};
    key.low += 0x9E3779B9u;
    key.high += 0xBB67AE85u;
  }
  return counter;
}

}  // namespace motes::particles
