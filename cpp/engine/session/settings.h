// Settings of a run, equal on all ranks but for `speed`, `threads`, `shares_pictures` and the functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "balance/policy.h"
#include "engine/session/costs.h"
#include "engine/session/round.h"

namespace motes::engine {

/// Who creates newborn particles: the manager, which deals them out (paper 3.2.1), or each calculator a part of them.
/// automatic: the manager chooses for each frame (births_by). The particles are the same in all.
enum class Births : std::uint8_t { automatic, manager, calculators };

/// How a run, or a part of it, began, as the log's table of events says it.
struct Opening {
  std::string kind;
  std::uint64_t frame = 0;
  std::string text;
};

/// What the run writes about itself.
struct Logging {
  std::string directory;           // empty: no log
  std::vector<std::string> hosts;  // one per rank
  bool spans = false;              // a timeline of each rank
  bool digest = false;             // fingerprint the particles of every frame
  std::uint64_t continued_from =
      0;  // the first frame of a run that goes on after another one, in its log; 0: a new run
  std::string lost;  // why some ranks are missing; empty: a continuation from a checkpoint
  std::vector<Opening> openings;  // before that
};

struct Settings {
  std::uint64_t seed = 0;
  double dt = 1.0 / 24;  // seconds per frame
  int substeps = 1;
  balance::PolicyPtr policy;  // null: cuts stay
  Combine combine = Combine::together;
  Births births = Births::automatic;
  int threads = 1;          // threads of this rank, for calculating and drawing
  std::size_t grain = SIZE_MAX;  // see threads::Pool
  std::optional<float> skin;  // of kept lists, as a part of how far a law sees, equal on all ranks; none: the cheapest
  bool shares_pictures = true;  // draw into the image generator's memory on its host: see SharedPictures
  int fan_out = 8;  // a rank relays the manager's messages to at most this many others
  bool blocking = false;  // calculators wait until the image generator has taken their particles (paper)
  bool wall_clock = false;  // compute seconds are wall time, not this thread's processor time
  double speed = 1;  // 0..1: this rank takes as long as a machine of this fraction of its speed would
  Costs costs;  // costs of work on a simulated machine
  Logging log;
  std::function<int()> stop_signal;  // the signal that asks this rank to stop, or 0; asked once per frame; may be empty
  std::function<std::string()>
      orders;  // image generator: what viewers ask for, which all ranks then hear; may be empty
};

}  // namespace motes::engine
