#include "simd/isa.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "base/invalid_argument.h"
#include "simd/builds.h"
#include "simd/generic.h"

namespace motes::simd {
namespace {

bool compiled(Isa isa) {
  constexpr bool kCompiled[] = MOTES_COMPILED;
  return kCompiled[static_cast<std::size_t>(isa)];
}

bool supports(Isa isa) {
#if defined(__x86_64__) && !defined(MOTES_GENERIC)
  switch (isa) {
    case Isa::avx512:
      return __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("avx512f") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
             __builtin_cpu_supports("avx512bw");
    case Isa::avx2: return __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("avx2");
    case Isa::sse2: return true;
    default: return false;
  }
#elif defined(__aarch64__) && !defined(MOTES_GENERIC)
  return isa == Isa::neon;
#else
  return isa == Isa::sse2;  // the portable build, four lanes
#endif
}

// Returns the names of sets, narrowest first, for messages: "sse2, avx2".
std::string names(bool (*has)(Isa)) {
  std::string all;
  for (const Isa isa : kIsas) {
    if (has(isa)) all += (all.empty() ? "" : ", ") + std::string(name(isa));
  }
  return all;
}

Isa widest() {
  for (const Isa isa : {Isa::avx512, Isa::avx2, Isa::neon, Isa::sse2}) {
    if (offers(isa)) return isa;
  }
  throw std::invalid_argument("the kernels are compiled for " + names(compiled) + ", but this processor supports " +
                              names(supports));
}

Isa decide() {
  const char* wish = std::getenv("MOTES_SIMD");
  if (wish == nullptr || *wish == '\0') return widest();
  for (const Isa isa : kIsas) {
    if (name(isa) != wish) continue;
    if (offers(isa)) return isa;
    const std::string why = supports(isa) ? ": the kernels are compiled for " : ": this processor supports ";
    throw std::invalid_argument("MOTES_SIMD=" + std::string(wish) + why + names(supports(isa) ? compiled : supports));
  }
  throw base::InvalidArgument("MOTES_SIMD", "be sse2, avx2, avx512 or neon", "'" + std::string(wish) + "'");
}

}  // namespace

bool offers(Isa isa) { return compiled(isa) && supports(isa); }

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
    case Isa::neon: return "neon";
    default: return "sse2";
  }
}

}  // namespace motes::simd
