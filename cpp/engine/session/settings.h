// Settings of a run, equal on all ranks except `speed`, `threads`, `shares_pictures` and the functions.
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

/// Who creates newborn particles: the manager, which deals them out (paper 3.2.1), or the calculators, each a part.
/// automatic: the manager chooses for each frame (births_by). The particles are the same in all cases.
enum class Births : std::uint8_t { automatic, manager, calculators };

/// How a run, or a part of it, began: a row of the log's table of events.
struct Opening {
  std::string kind;
  std::uint64_t frame = 0;
  std::string text;
};

/// What the run logs.
struct Logging {
  std::string directory;           // empty: no log
  std::vector<std::string> hosts;  // one per rank
  bool spans = false;              // log a timeline of each rank
  bool digest = false;             // log a digest of the particles of every frame
  std::uint64_t continued_from = 0;  // first frame, if this run continues another run's log; 0: a new run
  std::string lost;  // why ranks are missing; empty: a continuation from a checkpoint
  std::vector<Opening> openings;  // earlier openings
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
  std::optional<float> skin;  // of kept neighbour lists, as a fraction of the law's reach; none: the cheapest
  bool shares_pictures = true;  // draw into the image generator's memory on its host: see SharedPictures
  int fan_out = 8;  // a rank relays the manager's messages to at most this many others
  bool blocking = false;  // calculators wait until the image generator has received their particles (paper)
  bool wall_clock = false;  // measure compute in wall seconds, not processor seconds
  double speed = 1;  // 0..1: slow this rank down to this fraction of its speed
  Costs costs;  // on a simulated machine
  Logging log;
  std::function<int()> stop_signal;  // returns the signal that asks this rank to stop, or 0; called once per frame
  std::function<std::string()> orders;  // image generator: returns viewers' orders for all ranks; may be empty
};

}  // namespace motes::engine
