// All builds of the kernels that the processor can run.
#pragma once

#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "actions/kernels.h"
#include "base/hash.h"
#include "simd/builds.h"
#include "simd/declare_builds.h"
#include "simd/isa.h"
#include "support/lanes_probe.h"

MOTES_DECLARE_BUILDS(motes::actions::Kernels, action_kernels)
MOTES_DECLARE_BUILDS(test::Probe, probe)

namespace test {

struct Build {
  std::string name;
  const motes::actions::Kernels& kernels;
  const Probe& probe;
};

/// Returns those of MOTES_BUILDS(table) that this process can run, narrowest first.
template <class Table>
std::vector<const Table*> runnable(const Table* const (&builds)[std::size(motes::simd::kIsas)]) {
  std::vector<const Table*> found;
  for (const motes::simd::Isa isa : motes::simd::kIsas) {
    if (motes::simd::offers(isa)) found.push_back(builds[static_cast<std::size_t>(isa)]);
  }
  return found;
}

/// Returns the builds that this process can run, narrowest first.
inline std::vector<Build> builds() {
  const auto kernels = runnable<motes::actions::Kernels>(MOTES_BUILDS(action_kernels));
  const auto probes = runnable<Probe>(MOTES_BUILDS(probe));
  std::vector<Build> all;
  for (const motes::simd::Isa isa : motes::simd::kIsas) {
    if (!motes::simd::offers(isa)) continue;
    all.push_back({std::string(motes::simd::name(isa)), *kernels[all.size()], *probes[all.size()]});
  }
  return all;
}

/// Random numbers for the tests themselves: SplitMix64 (Steele, Lea, Flood 2014).
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t word() { return motes::base::next_random(state_); }
  /// Returns 0 .. below - 1.
  std::size_t below(std::size_t below) { return static_cast<std::size_t>(word() % below); }
  float between(float low, float high) { return low + (high - low) * static_cast<float>(word() >> 40) * 0x1p-24f; }
  bool coin() { return (word() & 1u) != 0; }

 private:
  std::uint64_t state_;
};

}  // namespace test
