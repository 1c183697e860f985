#include "particles/streams.h"

#include "particles/random.h"

namespace motes::particles {

Key system_key(std::uint64_t seed, std::uint32_t system) {
  using namespace MOTES_ISA;
  const Words4 counter{all_words(system), all_words(0x6d6f7465u), all_words(0x73u), Words{}};  // "motes"
  const Words4 mixed = philox<10>(counter, static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
  return {mixed.a[0], mixed.b[0]};
}

}  // namespace motes::particles
