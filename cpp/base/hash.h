// Hashes: fingerprints of bytes, and pseudorandom numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace motes::base {

/// 2^64 over the golden ratio, odd.
inline constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15u;

/// Mixes the bits of a number: the finaliser of SplitMix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom
/// number generators"). Always inline, so that a kernel never links a copy compiled for another instruction set.
[[gnu::always_inline]] constexpr std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// Returns the next number of SplitMix64 and advances its state.
[[gnu::always_inline]] constexpr std::uint64_t next_random(std::uint64_t& state) { return mix(state += kGolden); }

/// 128 bits, enough that different content has different hashes.
struct Hash {
  std::uint64_t low = 0;
  std::uint64_t high = 0;

  bool operator==(const Hash&) const = default;
};
Hash hash(std::span<const std::byte> bytes);

}  // namespace motes::base
