#include "particles/digest.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <vector>

#include "base/hash.h"

namespace motes::particles {
namespace {

using base::kGolden;
using base::mix;

// Adds one value to a hash. The multiplication and the rotation make the result depend on the order of the values. All
// NaNs count as the same, since the compiler decides which of two NaNs an operation returns.
std::uint64_t fold(std::uint64_t hash, float value) {
  const std::uint32_t bits = value == value ? std::bit_cast<std::uint32_t>(value) : 0x7fc00000u;
  return std::rotl((hash ^ bits) * kGolden, 29);
}

std::uint64_t fold(std::uint64_t hash, std::span<const Touch> touches) {
  for (const Touch& touch : touches) {
    hash = std::rotl((hash ^ (touch.id + touch.law * kGolden)) * kGolden, 29);
    for (const float way : touch.slid) hash = fold(hash, way);
    for (const float way : touch.rolled) hash = fold(hash, way);
  }
  return hash;
}

// Returns the digest of particles first .. last - 1, where `at(i)` is the index of particle i.
template <class At>
Digest sum(const Store& store, std::size_t first, std::size_t last, const At& at) {
  Digest result;
  result.particles = last - first;
  std::array<std::uint64_t, kBlock> hash;
  for (std::size_t begin = first; begin < last; begin += kBlock) {
    const std::size_t length = std::min(kBlock, last - begin);
    for (std::size_t i = 0; i < length; ++i) hash[i] = mix(store.ids()[at(begin + i)] + kGolden);
    for (int a = 0; a < store.schema().size(); ++a) {
      for (int c = 0; c < store.schema()[a].width; ++c) {
        const float* plane = store.plane(a, c);
        const float value = store.uniform_value(a)[static_cast<std::size_t>(c)];
        if (a >= contacts && a < builtin_count) {  // only values that differ from the initial one count
          const float none = store.schema()[a].initial[static_cast<std::size_t>(c)];
          for (std::size_t i = 0; i < length && (plane != nullptr || value != none); ++i) {
            const float some = plane ? plane[at(begin + i)] : value;
            if (some == none) continue;
            if (c > 0) hash[i] = fold(hash[i], static_cast<float>(c));
            hash[i] = fold(hash[i], some);
          }
          continue;
        }
        for (std::size_t i = 0; i < length; ++i) hash[i] = fold(hash[i], plane ? plane[at(begin + i)] : value);
      }
    }
    for (std::size_t i = 0; i < length && store.remembers(); ++i) {
      hash[i] = fold(hash[i], store.touches(at(begin + i)));
    }
    for (std::size_t i = 0; i < length; ++i) {
      result.first += mix(hash[i]);
      result.second += mix(hash[i] ^ 0xd6e8feb86659fd93u);
    }
  }
  return result;
}

void put_hex(std::string& text, std::uint64_t value) {
  constexpr const char* kDigits = "0123456789abcdef";
  for (int shift = 60; shift >= 0; shift -= 4) text.push_back(kDigits[value >> shift & 15u]);
}

}  // namespace

Digest& Digest::operator+=(const Digest& other) {
  first += other.first;
  second += other.second;
  particles += other.particles;
  return *this;
}

Digest& Digest::operator-=(const Digest& other) {
  first -= other.first;
  second -= other.second;
  particles -= other.particles;
  return *this;
}

std::string Digest::text() const {
  std::string text;
  put_hex(text, first);
  put_hex(text, second);
  put_hex(text, particles);
  return text;
}

Digest digest(const Store& store, threads::Pool& pool) {
  constexpr std::size_t kRange = 64 * kBlock;
  const std::size_t range = pool.items(kRange);
  std::vector<Digest> parts((store.size() + range - 1) / range);
  pool.run(parts.size(), [&](std::size_t part, std::size_t) {
    const std::size_t first = part * range;
    parts[part] = sum(store, first, std::min(store.size(), first + range), [](std::size_t i) { return i; });
  });
  Digest all;
  for (const Digest& part : parts) all += part;
  return all;
}

Digest digest(const Store& store, std::span<const std::uint32_t> indices) {
  return sum(store, 0, indices.size(), [&](std::size_t i) { return indices[i]; });
}

Digest combine(std::span<const Digest> systems) {
  Digest all;
  for (std::size_t i = 0; i < systems.size(); ++i) {
    const std::uint64_t salt = mix(kGolden * (i + 1));
    all.first += mix(systems[i].first ^ salt) + systems[i].particles * kGolden;
    all.second += mix(systems[i].second + salt);
    all.particles += systems[i].particles;
  }
  return all;
}

}  // namespace motes::particles
