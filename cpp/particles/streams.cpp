#include "particles/streams.h"

#include "particles/random.h"

namespace motes::particles {

Key system_key(std::uint64_t seed, std::uint32_t system) {
  using namespace MOTES_ISA;
  const Counter counter{all_wide(system), all_wide(0x6d6f7465u), all_wide(0x73u), Wide{}};  // "motes"
  const RoundKeys<10> keys(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
  const Counter mixed = philox<10>(counter, keys);
  return {static_cast<std::uint32_t>(mixed.a[0]), static_cast<std::uint32_t>(mixed.b[0])};
}

}  // namespace motes::particles
