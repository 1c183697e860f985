// What a run is set to: equal on all ranks but for `speed` and `threads`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "balance/policy.h"
#include "frame/costs.h"
#include "frame/round.h"

namespace motes::frame {

/// Who makes newborn particles: the manager, which deals them out (paper 3.2.1), or each calculator a part of them.
enum class Births : std::uint8_t { manager, calculators };

/// What the run writes about itself.
struct Logging {
  std::string directory;           // empty: no log
  std::vector<std::string> hosts;  // one per rank
  bool spans = false;              // a timeline of each rank
  bool digest = false;             // fingerprint the particles of every frame
};

struct Settings {
  std::uint64_t seed = 0;
  double dt = 1.0 / 24;  // seconds per frame
  int substeps = 1;
  balance::PolicyPtr policy;  // null: cuts stay
  Combine combine = Combine::together;
  Births births = Births::manager;
  int threads = 1;          // of this rank, for calculating and drawing
  std::size_t grain = SIZE_MAX;  // see threads::Pool
  int fan_out = 8;          // a rank relays the manager's messages to at most this many others
  bool blocking = false;    // calculators wait until the image generator has taken their particles (paper)
  bool wall_clock = false;  // compute seconds are wall time, not this thread's processor time
  double speed = 1;         // 0..1: this rank takes as long as a machine of this fraction of its speed would
  Costs costs;              // of work on a simulated machine
  Logging log;
};

}  // namespace motes::frame
