// Compiled once for each instruction set (see CMakeLists.txt).
#include "lanes_probe.h"
#include "particles/random.h"
#include "simd/elementary.h"

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
  for (std::size_t i = 0; i < count; i += kLanes) {
    Draws draws(keys, keys.first(), ids, i);
    for (int k = 0; k < skip; ++k) draws.bits();
    put(draws.bits(), out + 4 * i);
  }
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

}  // namespace

extern const test::Probe probe;
const test::Probe probe = {kLanes, lanes_of_draws, lanes_of_cos_sin, lanes_of_log, lanes_of_cube_root};

}  // namespace motes::MOTES_ISA
