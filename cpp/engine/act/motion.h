// How far particles move along the cut axis in a frame, from a sample, for the log.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/session/rank.h"
#include "engine/state/population.h"

namespace motes::engine {

/// A sample of a population before its list runs.
class Motion {
 public:
  /// Takes the sample; empty if the run has no log, or domains are cut by id or along a curve.
  Motion(const Rank& rank, const System& system, const Population& here);
  /// After the list has run, before migrants are removed: finds the sample again and sets `here.ways`.
  void measure(Population& here) const;

 private:
  struct Sampled {
    std::uint32_t at;
    std::uint64_t id;
    float x;
  };
  int axis_;
  std::vector<Sampled> sample_;
};

}  // namespace motes::engine
