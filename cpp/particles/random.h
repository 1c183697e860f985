// Philox4x32 counter-based random numbers: J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC11.
#pragma once

#include "particles/streams.h"
#include "simd/elementary.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {

/// Four words of a counter, lane by lane.
struct Words4 {
  Words a, b, c, d;
};

template <int Rounds>
MOTES_INLINE Words4 philox(Words4 counter, std::uint32_t key_low, std::uint32_t key_high) {
#pragma GCC unroll 10
  for (int round = 0; round < Rounds; ++round) {
    Words high0, low0, high1, low1;
    multiply_wide(counter.a, 0xD2511F53u, high0, low0);
    multiply_wide(counter.c, 0xCD9E8D57u, high1, low1);
    counter = {high1 ^ counter.b ^ key_low, low1, high0 ^ counter.d ^ key_high, low0};
    key_low += 0x9E3779B9u;
    key_high += 0xBB67AE85u;
  }
  return counter;
}

/// Uniform in [0, 1), a multiple of 2^-24.
MOTES_INLINE Floats unit(Words words) { return to_floats((Ints)(words >> 8)) * 0x1p-24f; }

/// Two standard normal numbers from two words (Box and Muller).
MOTES_INLINE void normal_pair(Words a, Words b, Floats& first, Floats& second) {
  const Floats u = (to_floats((Ints)(a >> 8)) + 1.0f) * 0x1p-24f;  // (0, 1]: the logarithm is finite
  const Floats r = sqrt(max(-2.0f * log(u), Floats{}));
  Floats cosine, sine;
  cos_sin_turn(unit(b), cosine, sine);
  first = r * cosine;
  second = r * sine;
}

/// The draws of one stream for the particles in one vector.
struct Draws {
  Words id_low, id_high;
  std::uint32_t step, stream;
  particles::Key key;
  std::uint32_t draw = 0;

  MOTES_INLINE Words4 words() {
    const std::uint32_t last = stream << particles::draw_bits | draw++;
    return philox<particles::philox_rounds>({id_low, id_high, all_words(step), all_words(last)}, key.low, key.high);
  }
};

}  // namespace motes::MOTES_ISA
