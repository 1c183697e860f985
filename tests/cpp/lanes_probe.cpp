// Compiled once for each instruction set (see CMakeLists.txt).
#include "lanes_probe.h"
#include "particles/random.h"
#include "simd/elementary.h"

namespace motes::MOTES_ISA {
namespace {

template <int Rounds>
void lanes_of_philox(const std::uint32_t counter[4], const std::uint32_t key[2], std::uint32_t* out) {
  Words first = all_words(counter[0]);
  for (std::size_t i = 0; i < kLanes; ++i) first[i] += static_cast<std::uint32_t>(i);
  const Words4 words =
      philox<Rounds>({first, all_words(counter[1]), all_words(counter[2]), all_words(counter[3])}, key[0], key[1]);
  for (std::size_t i = 0; i < kLanes; ++i) {
    out[4 * i] = words.a[i];
    out[4 * i + 1] = words.b[i];
    out[4 * i + 2] = words.c[i];
    out[4 * i + 3] = words.d[i];
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
const test::Probe probe = {kLanes,           lanes_of_philox<7>, lanes_of_philox<10>,
                           lanes_of_cos_sin, lanes_of_log,       lanes_of_cube_root};

}  // namespace motes::MOTES_ISA
