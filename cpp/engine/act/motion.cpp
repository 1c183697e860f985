#include "engine/act/motion.h"

#include <algorithm>
#include <cmath>

namespace motes::engine {
namespace {

constexpr std::size_t kSampled = 64;  // a few microseconds per frame

}  // namespace

Motion::Motion(const Rank& rank, const System& system, const Population& here) : axis_(system.definition.axes.first()) {
  if (rank.settings.log.directory.empty() || axis_ >= domains::kById) return;
  const particles::Store& store = here.store;
  const float* const x = store.plane(particles::position, axis_);
  const std::size_t count = std::min(store.size(), kSampled);
  sample_.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t at = k * store.size() / count;
    sample_.push_back({static_cast<std::uint32_t>(at), store.ids()[at], x[at]});
  }
}

void Motion::measure(Population& here) const {
  const particles::Store& store = here.store;
  const float* const x = sample_.empty() ? nullptr : store.plane(particles::position, axis_);
  std::vector<float> ways;
  std::vector<Sampled> elsewhere;
  const auto add = [&](const Sampled& of, std::size_t at) {
    if (const float way = x[at] - of.x; std::isfinite(way)) ways.push_back(way);
  };
  for (const Sampled& one : sample_) {
    if (one.at < store.size() && store.ids()[one.at] == one.id) {
      add(one, one.at);
    } else {
      elsewhere.push_back(one);
    }
  }
  // The run may have moved those that left the domain to another place; without them, ways would seem shorter.
  const auto by_id = [](const Sampled& a, const Sampled& b) { return a.id < b.id; };
  std::sort(elsewhere.begin(), elsewhere.end(), by_id);
  for (const std::uint32_t at : elsewhere.empty() ? std::vector<std::uint32_t>() : here.outcome.left) {
    const Sampled wanted{at, store.ids()[at], 0};
    const auto found = std::lower_bound(elsewhere.begin(), elsewhere.end(), wanted, by_id);
    if (found != elsewhere.end() && found->id == wanted.id) add(*found, at);
  }
  if (ways.empty()) return;
  std::sort(ways.begin(), ways.end());
  for (std::size_t k = 0; k < here.ways.size(); ++k) {
    here.ways[k] = ways[(2 * k + 1) * ways.size() / (2 * here.ways.size())];
  }
}

}  // namespace motes::engine
