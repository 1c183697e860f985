// Compiled once for each instruction set (see CMakeLists.txt).
#include "support/lanes_probe.h"
#include "particles/random.h"
#include "simd/elementary.h"
#include "simd/shorts.h"

namespace motes::MOTES_ISA {
namespace {

void put(const Uints4& bits, std::uint32_t* out) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    out[4 * i] = bits.a[i];
    out[4 * i + 1] = bits.b[i];
    out[4 * i + 2] = bits.c[i];
    out[4 * i + 3] = bits.d[i];
  }
}

void lanes_of_draws(const particles::Ids& ids, std::size_t count, std::uint32_t step, std::uint32_t stream,
                    const std::uint32_t key[2], int skip, std::uint32_t* out) {
  particles::DrawKeys keys;
  keys.begin({key[0], key[1]}, step, stream);
  for_draws<true>(keys, ids, count, [&](std::size_t i, Draws& draws) {
    for (int k = 0; k < skip; ++k) draws.bits();
    put(draws.bits(), out + 4 * i);
  });
}

void lanes_of_cos_sin(const float* turn, std::size_t count, float* cosine, float* sine) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    Floats c, s;
    cos_sin_turn(load(turn + i), c, s);
    store(cosine + i, c);
    store(sine + i, s);
  }
}

void lanes_of_log(const float* v, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; i += kLanes) store(out + i, log(load(v + i)));
}

void lanes_of_cube_root(const float* v, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; i += kLanes) store(out + i, cube_root(load(v + i)));
}

void lanes_of_pairs(const std::uint16_t* groups, const std::int32_t* weights, std::int32_t* out) {
  for (std::size_t i = 0; i < 16; i += kLanes) {
    const FourWords pairs = load_pairs([&](std::size_t lane) { return groups + 8 * (i + lane); });
    for (std::size_t c = 0; c < 4; ++c) {
      store_mask(out + 16 * c + i, pair_products((Ints)pairs.word[c], load_mask(weights + i)));
    }
  }
}

void lanes_of_thirds(const std::int32_t* planes, std::uint16_t* out) {
  for (std::size_t i = 0; i < 16; i += kLanes) {
    store_thirds(out + 3 * i, load_mask(planes + i), load_mask(planes + 16 + i), load_mask(planes + 32 + i));
  }
}

int greatest_number(const std::int16_t* numbers) {
  Shorts v;
  __builtin_memcpy(&v, numbers, sizeof v);
  return greatest_of(v);
}

}  // namespace

extern const test::Probe probe;
const test::Probe probe = {kLanes,         lanes_of_draws,  lanes_of_cos_sin, lanes_of_log, lanes_of_cube_root,
                           lanes_of_pairs, lanes_of_thirds, greatest_number};

}  // namespace motes::MOTES_ISA
