// A fingerprint of particles that does not depend on their order or on the rank that holds them.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "particles/store.h"

namespace motes::particles {

/// Sums, modulo 2^64, of two hashes per particle, each of its id and the bits of all its columns. Digests of parts add
/// up to that of the whole.
struct Digest {
  std::uint64_t first = 0;
  std::uint64_t second = 0;
  std::uint64_t particles = 0;

  Digest& operator+=(const Digest& other);
  Digest& operator-=(const Digest& other);
  bool operator==(const Digest&) const = default;

  /// Returns the digest as 48 hexadecimal digits.
  std::string text() const;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Digest& digest) {
  visit(digest.first, digest.second, digest.particles);
}

Digest digest(const Store& store, threads::Pool& pool = threads::alone());

/// Returns the digest of only these particles (ascending indices).
Digest digest(const Store& store, std::span<const std::uint32_t> indices);

/// Returns one digest of several systems, in order.
Digest combine(std::span<const Digest> systems);

}  // namespace motes::particles
