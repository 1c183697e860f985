// Counter-based random numbers: a draw is a function of its counter. Philox4x32 (J. Salmon et al., "Parallel random
// numbers: as easy as 1, 2, 3", SC11) makes keys, and a cheaper function of a key makes the draws of a particle.
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

/// The words of one draw that are the same for all particles: Philox of seed, system, step, stream and draw.
struct DrawKey {
  std::uint32_t word[8];
};

/// What all draws of one action have in common. Keys are computed when a draw is first asked for, a vector of them at
/// once.
class Stream {
 public:
  MOTES_INLINE Stream(std::uint32_t step, std::uint32_t stream, particles::Key key)
      : step_(step), stream_(stream), key_(key) {}

  MOTES_INLINE const DrawKey& of(std::uint32_t draw) const {
    draw %= kMost;
    while (draw >= ready_) prepare();
    return draws_[draw];
  }

 private:
  static constexpr std::uint32_t kMost = 1u << particles::draw_bits;
  static constexpr std::uint32_t kAtOnce = kLanes / 2;  // each draw takes two of Philox's results

  __attribute__((noinline)) void prepare() const {
    std::uint64_t lane[kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      lane[i] = stream_ << particles::draw_bits | (ready_ + static_cast<std::uint32_t>(i / 2));
    }
    const Wides streams = load_ids(lane);
    for (std::size_t i = 0; i < kLanes; ++i) lane[i] = i % 2;
    const Wides halves = load_ids(lane);
    const RoundKeys<particles::philox_rounds> keys(key_.low, key_.high);
    const Wide step = all_wide(step_), tag = all_wide(0x6d6f7465u);  // "mote"
    const Counter one = philox<particles::philox_rounds>({step, streams.first, tag, halves.first}, keys);
    const Counter two = philox<particles::philox_rounds>({step, streams.second, tag, halves.second}, keys);
    const Uints4 words = join(one, two);
    for (std::uint32_t i = 0; i < kLanes; ++i) {
      std::uint32_t* to = draws_[ready_ + i / 2].word + 4 * (i % 2);
      to[0] = words.a[i];
      to[1] = words.b[i];
      to[2] = words.c[i];
      to[3] = words.d[i];
    }
    ready_ += kAtOnce;
  }

  std::uint32_t step_, stream_;
  particles::Key key_;
  mutable std::uint32_t ready_ = 0;
  mutable DrawKey draws_[kMost];
};

/// Four words for each of kLanes ids: two keyed 32-bit mixes of the id (multiply and xor-shift, after C. Wellons'
/// search for integer hashes), then each word from both, so that no word is a permutation of the ids. The key hides
/// what steps, places, draws, systems and seeds have in common; the mixes, what ids have. docs/speed.md has the tests
/// that it passes.
MOTES_INLINE Uints4 random_bits(const DrawKey& key, const std::uint64_t* ids) {
  const Wides id = load_ids(ids);
  const Uints low = join(id), high = join({upper(id.first), upper(id.second)});
  const auto k = [&](int i) { return all_uints(key.word[i]); };
  Uints a = (low + high * 0x9E3779B1u) ^ k(0);
  a ^= a >> 16;
  a *= 0x7feb352du;
  a ^= a >> 15;
  a += k(1);
  a *= 0x846ca68bu;
  a ^= a >> 16;
  Uints b = (low + high * 0x85EBCA6Au) ^ k(2);  // even: (low, high) -> (a, b) is one to one
  b ^= b >> 15;
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

/// The first draws of all particles in a block.
struct BlockBits {
  static constexpr std::size_t kRoom = particles::kBlock + particles::kPadding;
  std::uint32_t drawn[4][kRoom];

  // Not inlined: all actions and shapes share this code. `ask` is called with 0, 16, 32, ... below count along the way.
  template <class Ask>
  __attribute__((noinline)) void fill(const Stream& from, const std::uint64_t* ids, std::size_t count, const Ask& ask) {
    const DrawKey& key = from.of(0);
    for (std::size_t i = 0, asked = 0; i < count; i += kLanes) {
      for (; asked < i + kLanes; asked += 16) ask(asked);
      put(random_bits(key, ids + i), i);
    }
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
  return random_bits(from.of(draw), ids);
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
