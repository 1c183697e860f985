// Philox4x32 counter-based random numbers: J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC11.
#pragma once

#include "particles/blocks.h"
#include "particles/streams.h"
#include "simd/elementary.h"
#include "simd/wides.h"

namespace motes::MOTES_ISA {

/// Four uint32 per lane.
struct Uints4 {
  Uints a, b, c, d;
};

inline constexpr std::uint32_t kFirstFactor = 0xD2511F53u, kSecondFactor = 0xCD9E8D57u;

/// The keys of all rounds, the same in all lanes: computed once for a block of particles.
template <int Rounds>
struct RoundKeys {
  Wide low[Rounds], high[Rounds];

  MOTES_INLINE RoundKeys(std::uint32_t key_low, std::uint32_t key_high) {
    for (int round = 0; round < Rounds; ++round) {
      low[round] = all_wide(key_low + static_cast<std::uint32_t>(round) * 0x9E3779B9u);
      high[round] = all_wide(key_high + static_cast<std::uint32_t>(round) * 0xBB67AE85u);
    }
  }
};

/// A counter between rounds: half of the lanes.
struct Counter {
  Wide a, b, c, d;
};

template <int Rounds>
MOTES_INLINE Counter philox_round(Counter counter, const RoundKeys<Rounds>& keys, int round) {
  const Wide first = multiply(counter.a, all_wide(kFirstFactor));
  const Wide second = multiply(counter.c, all_wide(kSecondFactor));
  return {exclusive_or(counter.b, keys.low[round], upper(second)), second,
          exclusive_or(counter.d, keys.high[round], upper(first)), first};
}

template <int Rounds>
MOTES_INLINE Counter philox(Counter counter, const RoundKeys<Rounds>& keys) {
#pragma GCC unroll 10
  for (int round = 0; round < Rounds; ++round) counter = philox_round(counter, keys, round);
  return counter;
}

MOTES_INLINE Uints4 join(const Counter& first, const Counter& second) {
  return {join({first.a, second.a}), join({first.b, second.b}), join({first.c, second.c}), join({first.d, second.d})};
}

/// Uniform in [0, 1), a multiple of 2^-24.
MOTES_INLINE Floats unit(Uints bits) { return to_floats((Ints)(bits >> 8)) * 0x1p-24f; }

/// Two standard normal numbers from two uint32 (Box and Muller).
MOTES_INLINE void normal_pair(Uints a, Uints b, Floats& first, Floats& second) {
  const Floats u = (to_floats((Ints)(a >> 8)) + 1.0f) * 0x1p-24f;  // (0, 1]: the logarithm is finite
  const Floats r = sqrt(max(-2.0f * log(u), Floats{}));
  Floats cosine, sine;
  cos_sin_turn(unit(b), cosine, sine);
  first = r * cosine;
  second = r * sine;
}

/// What all draws of one action have in common.
struct Stream {
  std::uint32_t step, stream;
  RoundKeys<particles::philox_rounds> keys;

  MOTES_INLINE Stream(std::uint32_t step_number, std::uint32_t stream_number, particles::Key key)
      : step(step_number), stream(stream_number), keys(key.low, key.high) {}
};

/// Philox of (id, step, stream and draw) for the particles in `Vectors` vectors. The rounds of a single vector spend
/// most of the time waiting for each other; a second vector fills the gaps.
template <int Vectors>
MOTES_INLINE void random_bits(const Stream& from, const std::uint64_t* ids, std::uint32_t draw, Uints4* out) {
  // The second half of the counter is the same in all lanes, so round 0 needs only half of the multiplications.
  const std::uint64_t second = std::uint64_t{from.step} * kSecondFactor;
  const Wide a = all_wide(static_cast<std::uint32_t>(second >> 32)) ^ from.keys.low[0];
  const Wide b = all_wide(static_cast<std::uint32_t>(second));
  const Wide c = all_wide(from.stream << particles::draw_bits | draw) ^ from.keys.high[0];
  Counter counter[2 * Vectors];
#pragma GCC unroll 4
  for (int k = 0; k < Vectors; ++k) {
    const Wides id = load_ids(ids + static_cast<std::size_t>(k) * kLanes);
    const Wide first = multiply(id.first, all_wide(kFirstFactor)), other = multiply(id.second, all_wide(kFirstFactor));
    counter[2 * k] = {upper(id.first) ^ a, b, upper(first) ^ c, first};
    counter[2 * k + 1] = {upper(id.second) ^ a, b, upper(other) ^ c, other};
  }
#pragma GCC unroll 10
  for (int round = 1; round < particles::philox_rounds; ++round) {
#pragma GCC unroll 4
    for (int k = 0; k < 2 * Vectors; ++k) counter[k] = philox_round(counter[k], from.keys, round);
  }
#pragma GCC unroll 4
  for (int k = 0; k < Vectors; ++k) out[k] = join(counter[2 * k], counter[2 * k + 1]);
}

/// The first draws of all particles in a block.
struct BlockBits {
  static constexpr std::size_t kRoom = particles::kBlock + particles::kPadding;
  std::uint32_t drawn[4][kRoom];

  // Not inlined: all actions and shapes share this code. `ask` is called with 0, 16, 32, ... below count along the way.
  template <class Ask>
  __attribute__((noinline)) void fill(const Stream& from, const std::uint64_t* ids, std::size_t count, const Ask& ask) {
    std::size_t i = 0, asked = 0;
    for (; i + kLanes < count; i += 2 * kLanes) {
      for (; asked < i + 2 * kLanes; asked += 16) ask(asked);
      Uints4 bits[2];
      random_bits<2>(from, ids + i, 0, bits);
      put(bits[0], i);
      put(bits[1], i + kLanes);
    }
    if (i >= count) return;
    Uints4 bits[1];
    random_bits<1>(from, ids + i, 0, bits);
    put(bits[0], i);
  }
  MOTES_INLINE Uints4 at(std::size_t i) const {
    return {load_uints(drawn[0] + i), load_uints(drawn[1] + i), load_uints(drawn[2] + i), load_uints(drawn[3] + i)};
  }

 private:
  MOTES_INLINE void put(const Uints4& bits, std::size_t i) {
    store_uints(drawn[0] + i, bits.a);
    store_uints(drawn[1] + i, bits.b);
    store_uints(drawn[2] + i, bits.c);
    store_uints(drawn[3] + i, bits.d);
  }
};

__attribute__((noinline)) inline Uints4 random_bits_of(const Stream& from, const std::uint64_t* ids,
                                                       std::uint32_t draw) {
  Uints4 bits[1];
  random_bits<1>(from, ids, draw, bits);
  return bits[0];
}

/// The draws of one stream for the particles in one vector, one after another.
struct Draws {
  const Stream* from;
  const std::uint64_t* ids;
  const BlockBits* ready = nullptr;  // the first draw, at `at`
  std::size_t at = 0;
  std::uint32_t draw = 0;

  MOTES_INLINE Draws(const Stream& stream, const std::uint64_t* first_id) : from(&stream), ids(first_id) {}
  MOTES_INLINE Draws(const Stream& stream, const std::uint64_t* block_ids, const BlockBits& bits, std::size_t i)
      : from(&stream), ids(block_ids + i), ready(&bits), at(i) {}

  MOTES_INLINE Uints4 bits() {
    const std::uint32_t number = draw++;
    return ready != nullptr && number == 0 ? ready->at(at) : random_bits_of(*from, ids, number);
  }
};

}  // namespace motes::MOTES_ISA
