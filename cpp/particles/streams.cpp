#include "particles/streams.h"

#include "particles/philox.h"

namespace motes::particles {
namespace {

constexpr std::uint32_t kMote = 0x6d6f7465u, kS = 0x73u;  // "mote", "s"

}  // namespace

Key system_key(std::uint64_t seed, std::uint32_t system) {
  const Key whole{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)};
  const Words mixed = philox({system, kMote, kS, 0}, whole, 10);
  return {mixed[0], mixed[1]};
}

DrawKey draw_key(Key key, std::uint32_t step, std::uint32_t stream, std::uint32_t draw) {
  const std::uint32_t attempt = draw >> 16;
  const std::uint32_t which = stream << draw_bits | (draw & 0xffffu);
  DrawKey made{};
  for (std::uint32_t half = 0; half < 2; ++half) {
    const Words words = philox({step, which, kMote, 2 * attempt + half}, key, 10);
    for (std::uint32_t i = 0; i < 4; ++i) made.word[4 * half + i] = words[i];
  }
  return made;
}

void DrawKeys::make_first(Key key, std::uint32_t step, std::uint32_t stream) {
  first_ = draw_key(key, step, stream, 0);
  key_ = key;
  step_ = step;
  stream_ = stream;
  later_draw_ = 0;
}

const DrawKey& DrawKeys::later(std::uint32_t draw) {
  if (draw != later_draw_) later_ = draw_key(key_, step_, stream_, draw);
  later_draw_ = draw;
  return later_;
}

}  // namespace motes::particles
