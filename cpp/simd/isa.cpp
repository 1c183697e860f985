#include "simd/isa.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "simd/generic.h"

namespace motes::simd {
namespace {

bool offers(Isa isa) {
#if defined(__x86_64__) && !defined(MOTES_GENERIC)
  switch (isa) {
    case Isa::avx512:
      return __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("avx512f") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
             __builtin_cpu_supports("avx512bw");
    case Isa::avx2: return __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("avx2");
    default: return true;
  }
#else
  return isa == Isa::sse2;  // the portable build, four lanes
#endif
}

Isa decide() {
  const Isa widest = offers(Isa::avx512) ? Isa::avx512 : offers(Isa::avx2) ? Isa::avx2 : Isa::sse2;
  const char* wish = std::getenv("MOTES_SIMD");
  if (wish == nullptr || *wish == '\0') return widest;
  for (const Isa isa : {Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (name(isa) != wish) continue;
    if (offers(isa)) return isa;
    throw std::invalid_argument("MOTES_SIMD=" + std::string(wish) + ": this processor supports at most " +
                                std::string(name(widest)));
  }
  throw std::invalid_argument("MOTES_SIMD=" + std::string(wish) + ": must be sse2, avx2 or avx512");
}

}  // namespace

Isa isa() {
  static const Isa chosen = decide();
  return chosen;
}

bool fetches_ahead() {
#if defined(__x86_64__) && !defined(MOTES_GENERIC)
  return isa() != Isa::sse2 && __builtin_cpu_is("intel");
#else
  return false;
#endif
}

std::string_view name(Isa isa) {
  switch (isa) {
    case Isa::avx512: return "avx512";
    case Isa::avx2: return "avx2";
    default: return "sse2";
  }
}

}  // namespace motes::simd
