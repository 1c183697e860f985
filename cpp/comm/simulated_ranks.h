// Ranks that are threads of one process, for tests of conversations without MPI. Exactly one of them runs at a time.
// Which one runs next is drawn at every point where a rank sends, polls or waits, so a seed determines the order of
// events.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "comm/errors.h"
#include "comm/transport.h"

namespace motes::comm {

/// All ranks wait, and nothing in flight could end that. The text tells who waits for whom.
class Deadlock : public CommError {
  using CommError::CommError;
};

struct Simulation {
  int ranks = 2;  // 1 to 64
  std::uint64_t seed = 0;  // for the order of events
  /// Seed for the durations of work and messages; by default `seed`. Durations do not depend on the order of events:
  /// runs with one timing_seed and many seeds must agree on everything that the ranks decide, clocks included.
  std::optional<std::uint64_t> timing_seed{};

  double speed = 1e9;  // operations per second of each rank, for comm::execute
  double latency_s = 20e-6;  // of a message
  double bandwidth = 1e9;  // bytes per second
  double variation = 0.5;  // each of the three varies by up to this part, up and down

  /// A rank that dies: it stops silently at its n-th point (where it sends, polls or waits), its n-th send or its n-th
  /// call of Transport::shrink. What it sent before may arrive.
  struct Death {
    enum class At : std::uint8_t { point, send, shrink };
    int rank;
    std::uint64_t point;
    At at = At::point;
  };
  std::vector<Death> deaths{};
  /// The value of Transport::survives. If true, news of losses and revocations reaches each rank after an individual
  /// delay, and the consequences of a death, including times, depend on the order of events.
  bool survives = false;
  bool trace = false;  // keep a list of all events
};

/// What happened in a run.
struct SimulatedRun {
  std::vector<std::string> events;  // with Simulation::trace: "3 sends report to 1", in order
  std::uint64_t fingerprint = 0;  // hash of the order of events
  std::uint64_t points = 0;  // points at which another rank could have continued
  std::vector<double> clocks_s;  // each rank's time at its end
  std::vector<int> dead;
};

/// A simulated rank. On its thread the functions of comm/clock.h return its own simulated time.
class SimulatedRank {
 public:
  virtual ~SimulatedRank() = default;
  virtual int rank() const = 0;
  /// Returns this rank's end of the connections. May be called once.
  virtual std::unique_ptr<Transport> transport() = 0;
  /// Returns whether a rank has not died (one that has returned is alive), for Watch::life.
  virtual bool alive(int rank) const = 0;
};

/// Runs `body` on every rank until all have ended. The first exception on a rank ends the run: on the others the next
/// send, poll or wait throws an object that is not a std::exception, and simulate() throws the original. A deadlock
/// throws Deadlock on every waiting rank.
SimulatedRun simulate(const Simulation& simulation, const std::function<void(SimulatedRank&)>& body);

}  // namespace motes::comm
