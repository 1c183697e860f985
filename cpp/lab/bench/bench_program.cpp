#include "lab/bench/bench_program.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "lab/bench/bench_scene.h"
#include "program/program.h"

namespace motes::bench {
namespace {

using namespace recording;

using particles::Store;

struct Scene {
  particles::Schema schema;
  Store store;
  program::Program program;
  program::ListResult outcome;
  std::uint64_t frame = 0;

  Scene(const std::string& name, std::size_t particles)
      : store(make(full_air(particles), schema, {1, 2}, 0, particles, 0)), program(paper_list(name)) {}

  double step(const program::Slice& slice) {
    const double start = cpu_now();
    outcome.clear();
    program.run(store, 0, 0, {frame++, 1, 1.0 / 24, 0}, {1, 2}, slice, outcome);
    return cpu_now() - start;
  }
};

// Bins of equal width along x, each a vector of particle indices that is updated after every move. A particle is
// compared with the two edges of its bin; only particles in the outer bins can have left the domain.
struct SortedBins {
  float low, width;
  std::vector<std::vector<std::uint32_t>> members;

  SortedBins(const Store& store, float low_edge, float high_edge, int count)
      : low(low_edge), width((high_edge - low_edge) / static_cast<float>(count)),
        members(static_cast<std::size_t>(count)) {
    const float* x = store.plane(particles::position, 0);
    for (std::size_t i = 0; i < store.size(); ++i) members[bin_of(x[i])].push_back(static_cast<std::uint32_t>(i));
  }
  std::size_t bin_of(float x) const {
    const float at = std::floor((x - low) / width);
    return static_cast<std::size_t>(std::clamp(at, 0.0f, static_cast<float>(members.size() - 1)));
  }
  std::size_t update(const float* x, float high) {
    std::size_t migrants = 0;
    std::vector<std::pair<std::size_t, std::uint32_t>> moved;
    for (std::size_t b = 0; b < members.size(); ++b) {
      const float from = low + width * static_cast<float>(b);
      const float to = from + width;
      auto& bin = members[b];
      for (std::size_t i = 0; i < bin.size();) {
        const float at = x[bin[i]];
        if (at >= from && at < to) {
          ++i;
          continue;
        }
        if (at < low || at >= high) ++migrants;
        moved.emplace_back(bin_of(at), bin[i]);
        bin[i] = bin.back();
        bin.pop_back();
      }
    }
    for (const auto& [bin, index] : moved) members[bin].push_back(index);
    return migrants;
  }
};

}  // namespace

ActBench act_bench(const std::string& scene, std::size_t particles, int steps) {
  if (particles == 0) throw std::invalid_argument("particles must be at least 1, got 0");
  if (steps < 1) throw std::invalid_argument("steps must be at least 1, got " + std::to_string(steps));
  Scene s(scene, particles);
  s.step({});
  touch(s.store, kStepped, kStepped);
  std::vector<double> step_s, touch_s, ratios;
  for (int i = 0; i < steps; ++i) {
    step_s.push_back(s.step({0, -50.5f, 50.5f}));
    const double start = cpu_now();
    touch(s.store, kStepped, kStepped);
    touch_s.push_back(cpu_now() - start);
    ratios.push_back(touch_s.back() / step_s.back());
  }
  const double n = static_cast<double>(particles);
  return {n / median(step_s), n / median(touch_s), median(ratios), static_cast<double>(s.store.memory_bytes()) / n};
}

LeaverBench leaver_bench(std::size_t particles, int bins, int steps) {
  if (bins < 1) throw std::invalid_argument("bins must be at least 1, got " + std::to_string(bins));
  if (particles == 0 || steps < 1) throw std::invalid_argument("particles and steps must be at least 1");
  Scene s("fountain", particles);
  const program::Slice everything;
  const program::Slice domain{0, -50.5f, 50.5f};
  s.step(everything);
  SortedBins sorted(s.store, domain.low, domain.high, bins);
  std::vector<double> none, fused, scanned, binned;
  for (int i = 0; i < steps; ++i) {
    none.push_back(s.step(everything));
    fused.push_back(s.step(domain));
    scanned.push_back(s.step(everything));
    double start = cpu_now();
    program::Program::find_migrants(s.store, 0, domain, s.outcome);
    scanned.back() += cpu_now() - start;
    sorted.update(s.store.plane(particles::position, 0), domain.high);  // catch up with the steps above, not timed
    binned.push_back(s.step(everything));
    start = cpu_now();
    sorted.update(s.store.plane(particles::position, 0), domain.high);
    binned.back() += cpu_now() - start;
  }
  return {median(none), median(fused), median(scanned), median(binned)};
}

}  // namespace motes::bench
