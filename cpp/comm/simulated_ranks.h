// Ranks that are threads of one process, for tests of conversations without MPI. Exactly one of them runs at a time.
// Who runs next is drawn at every point where a rank sends, polls or waits, so one seed is one order of events, and the
// same seed is the same order again.
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

/// All ranks wait, and nothing is under way that could end it. Says who waits for whom.
class Deadlock : public CommError {
  using CommError::CommError;
};

struct Simulation {
  int ranks = 2;  // 1 to 64
  std::uint64_t seed = 0;  // of the order of events
  /// Of how long work and messages take; by default the seed. Time does not depend on the order of events: runs with
  /// one of these and many seeds must agree on everything that the ranks decide, clocks included.
  std::optional<std::uint64_t> timing_seed{};

  double speed = 1e9;  // operations per second of each rank, for comm::execute
  double latency_s = 20e-6;  // of a message
  double bandwidth = 1e9;  // bytes per second
  double variation = 0.5;  // each of these varies by up to this part, up and down

  /// A rank that dies: it stops at its n-th point of the kind above, or where it sends for the n-th time, or asks
  /// Transport::shrink for the n-th time, without a word. What it sent before may arrive.
  struct Death {
    enum class At : std::uint8_t { point, send, shrink };
    int rank;
    std::uint64_t point;
    At at = At::point;
  };
  std::vector<Death> deaths{};
  /// Transport::survives. News of losses and revocations then reach each rank after a time of its own. What follows
  /// from a death depends on the order of events, in times as well.
  bool survives = false;
  bool trace = false;  // keep a list of all events
};

/// What happened in a run.
struct SimulatedRun {
  std::vector<std::string> events;  // with Simulation::trace: "3 sends report to 1", in order
  std::uint64_t fingerprint = 0;  // of the order of events
  std::uint64_t points = 0;  // where another rank could have gone on
  std::vector<double> clocks_s;  // each rank's time at its end
  std::vector<int> dead;
};

/// What a simulated rank does. On its thread the functions of comm/clock.h give its own simulated time.
class SimulatedRank {
 public:
  virtual ~SimulatedRank() = default;
  virtual int rank() const = 0;
  /// This rank's end of the connections: once.
  virtual std::unique_ptr<Transport> transport() = 0;
  /// Whether a rank has not died (one that has returned lives): for Watch::alive.
  virtual bool alive(int rank) const = 0;
};

/// Runs `body` on every rank, to the end of all. The first exception on a rank ends the run on all of them: there the
/// next send, poll or wait throws something that is no std::exception, and simulate() throws the original. A deadlock
/// throws Deadlock on every rank that waits.
SimulatedRun simulate(const Simulation& simulation, const std::function<void(SimulatedRank&)>& body);

}  // namespace motes::comm
