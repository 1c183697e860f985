// The three builds of the kernels side by side, where the processor has them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "actions/kernels.h"
#include "lanes_probe.h"
#include "simd/generic.h"

namespace motes {
namespace sse2 {
extern const actions::Kernels action_kernels;
extern const test::Probe probe;
}  // namespace sse2
namespace avx2 {
extern const actions::Kernels action_kernels;
extern const test::Probe probe;
}  // namespace avx2
namespace avx512 {
extern const actions::Kernels action_kernels;
extern const test::Probe probe;
}  // namespace avx512
}  // namespace motes

namespace test {

struct Build {
  std::string name;
  const motes::actions::Kernels& kernels;
  const Probe& probe;
};

/// The builds that this processor can run.
inline std::vector<Build> builds() {
  std::vector<Build> all{{"sse2", motes::sse2::action_kernels, motes::sse2::probe}};
#if defined(__x86_64__) && !defined(MOTES_GENERIC)
  if (__builtin_cpu_supports("avx2")) all.push_back({"avx2", motes::avx2::action_kernels, motes::avx2::probe});
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw")) {
    all.push_back({"avx512", motes::avx512::action_kernels, motes::avx512::probe});
  }
#else
  all.push_back({"avx2", motes::avx2::action_kernels, motes::avx2::probe});
  all.push_back({"avx512", motes::avx512::action_kernels, motes::avx512::probe});
#endif
  return all;
}

/// Random numbers for the tests themselves: SplitMix64 (Steele, Lea, Flood 2014).
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t word() {
    std::uint64_t x = state_ += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  /// 0 .. below - 1.
  std::size_t below(std::size_t below) { return static_cast<std::size_t>(word() % below); }
  float between(float low, float high) { return low + (high - low) * static_cast<float>(word() >> 40) * 0x1p-24f; }
  bool coin() { return (word() & 1u) != 0; }

 private:
  std::uint64_t state_;
};

}  // namespace test
