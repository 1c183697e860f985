// Counter-based random numbers: a draw is a function of its counter. Philox4x32 (J. Salmon et al., "Parallel random
// numbers: as easy as 1, 2, 3", SC11) makes keys, and a cheaper function of a key makes the draws of a particle.
#pragma once

#include "particles/ids.h"
#include "particles/streams.h"
#include "simd/elementary.h"

namespace motes::MOTES_ISA {

/// Four uint32 per lane.
struct Uints4 {
  Uints a, b, c, d;
};

/// Returns a uniform whole number in 0..2^24 - 1.
MOTES_INLINE Floats whole(Uints bits) { return to_floats((Ints)(bits >> 8)); }

/// Returns a uniform number in [0, 1), a multiple of 2^-24.
MOTES_INLINE Floats unit(Uints bits) { return whole(bits) * 0x1p-24f; }

/// Makes two standard normal numbers from two uint32 (Box and Muller).
MOTES_INLINE void normal_pair(Uints a, Uints b, Floats& first, Floats& second) {
  const Floats u = (to_floats((Ints)(a >> 8)) + 1.0f) * 0x1p-24f;  // (0, 1]: the logarithm is finite
  const Floats r = sqrt(max(-2.0f * log(u), Floats{}));
  Floats cosine, sine;
  cos_sin_turn(unit(b), cosine, sine);
  first = r * cosine;
  second = r * sine;
}

/// Returns four words for each of kLanes ids, whose mixes begin with `id_a` and `id_b`: two keyed 32-bit mixes of the
/// id (multiply and xor-shift, after C. Wellons' search for integer hashes), then each word from both, so no word is a
/// permutation of the ids. The key hides similarities of steps, places, draws, systems and seeds; the mixes hide those
/// of ids. docs/lab/speed.md lists the tests that it passes.
MOTES_INLINE Uints4 random_bits(const particles::DrawKey& key, Uints id_a, Uints id_b) {
  const auto k = [&](int i) { return all_uints(key.word[i]); };
  // a ^= k; a ^= a >> 16; the key's part is the same for all lanes and computed separately
  const auto mixed = [&](int i, int shift) { return all_uints(key.word[i] ^ key.word[i] >> shift); };
  Uints a = xor3(id_a, id_a >> 16, mixed(0, 16));
  a *= 0x7feb352du;
  a ^= a >> 15;
  a += k(1);
  a *= 0x846ca68bu;
  a ^= a >> 16;
  Uints b = xor3(id_b, id_b >> 15, mixed(2, 15));
  b *= 0xd168aaadu;
  b ^= b >> 15;
  b += k(3);
  b *= 0xaf723597u;
  b ^= b >> 15;
  Uints4 out;
  out.a = (a ^ k(4)) * 0x9E3779B1u;
  out.a = (out.a ^ out.a >> 16) + b;
  out.b = (b ^ k(5)) * 0x85EBCA77u;
  out.b = (out.b ^ out.b >> 16) + (a << 16 | a >> 16);
  out.c = (a + b + k(6)) * 0xC2B2AE3Du;
  out.c ^= out.c >> 16;
  out.d = ((a ^ (b << 7 | b >> 25)) + k(7)) * 0x27D4EB2Fu;
  out.d ^= out.d >> 15;
  return out;
}

/// Returns the words of the ids from number `at` on.
MOTES_INLINE Uints4 random_bits(const particles::DrawKey& key, const particles::Ids& ids, std::size_t at) {
  Uints id_a = load_uints(ids.lower + at);
  Uints id_b = id_a;
  if (ids.upper != nullptr) [[unlikely]] {
    const Uints upper = load_uints(ids.upper + at);
    id_a += upper * 0x9E3779B1u;
    id_b += upper * 0x85EBCA6Au;  // even: (lower, upper) -> (id_a, id_b) is one to one
  }
  return random_bits(key, id_a, id_b);
}

__attribute__((noinline)) inline Uints4 random_bits_of(particles::DrawKeys& keys, const particles::Ids& ids,
                                                       std::size_t at, std::uint32_t draw) {
  return random_bits(keys.later(draw), ids, at);
}

/// The draws of one stream for the particles in one vector, one after another.
struct Draws {
  particles::DrawKeys* keys;
  Uints4 first;  // the first draw's words; compilers drop them if unused
  const particles::Ids* ids;
  std::size_t at;  // the vector's first particle
  std::uint32_t draw = 0;

  MOTES_INLINE Draws(particles::DrawKeys& stream, const Uints4& first_words, const particles::Ids& all,
                     std::size_t first_particle)
      : keys(&stream), first(first_words), ids(&all), at(first_particle) {}

  MOTES_INLINE Uints4 bits() {
    const std::uint32_t number = draw++;
    return number == 0 ? first : random_bits_of(*keys, *ids, at, number);
  }
};

/// Calls work(first particle, draws) for each vector of `count` particles. `Together`, for short work that draws once:
/// draws the first words of four vectors before any of them is used. A vector's words result from a chain of dependent
/// operations, and processors do not look far enough ahead to overlap several chains with other work in between. Ids
/// with upper halves, which are rare, are drawn one vector at a time: a test of each vector would keep the compiler
/// from interleaving the four.
template <bool Together, class Work>
MOTES_INLINE void for_draws(particles::DrawKeys& keys, const particles::Ids& ids, std::size_t count, const Work& work) {
  constexpr std::size_t kVectors = 4;
  const particles::DrawKey first = keys.first();  // a local copy
  const auto use = [&](std::size_t i, const Uints4& words) __attribute__((always_inline)) {
    Draws draws(keys, words, ids, i);
    work(i, draws);
  };
  std::size_t i = 0;
  if constexpr (Together) {
    for (const bool narrow = ids.upper == nullptr; narrow && i + (kVectors - 1) * kLanes < count;
         i += kVectors * kLanes) {
      Uints4 words[kVectors];
#pragma GCC unroll 4
      for (std::size_t k = 0; k < kVectors; ++k) {
        const Uints id = load_uints(ids.lower + i + k * kLanes);
        words[k] = random_bits(first, id, id);
      }
#pragma GCC unroll 4
      for (std::size_t k = 0; k < kVectors; ++k) use(i + k * kLanes, words[k]);
    }
  }
  for (; i < count; i += kLanes) use(i, random_bits(first, ids, i));
}

}  // namespace motes::MOTES_ISA
