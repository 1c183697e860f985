// Messages in flight between simulated ranks, and when each rank learns of them. Knows the time, but not who runs next.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "comm/simulated_machine.h"
#include "comm/simulated_ranks.h"

namespace motes::comm::simulation {

/// What a rank waits for.
enum class WaitFor : std::uint8_t { none, message, sent, entered, finished, shrunk };

using From = std::pair<int, Phase>;

/// The connections among some ranks, which have their own numbers here. The first object connects all ranks; each
/// shrink() makes another. If the simulation survives losses, each function except revoke() and shrink() throws
/// RankLost when the calling rank knows of a loss that concerns it.
class Connections {
 public:
  /// `entered`: all ranks count as entered.
  Connections(const Simulation& simulation, std::vector<SimulatedMachine*> members, bool entered);

  int size() const { return static_cast<int>(ends_.size()); }
  SimulatedMachine& machine(int rank) const { return *end(rank).machine; }

  void send(int self, int to, Phase phase, std::shared_ptr<const Message> message);
  std::optional<base::Bytes> receive(int self, From from);
  std::optional<int> unsent(int self);
  /// Brings this rank to the point where all ranks enter, or finish. Returns whether all have come and it knows.
  bool arrive_at(int self, WaitFor point);
  void revoke(int self);
  /// Returns the connections among the surviving ranks, once all of them have called this; null before.
  std::shared_ptr<Connections> shrink(int self, std::vector<int>& survivors);

  /// Returns the time from which the wait is over, or a loss is known. kNever: something must happen first.
  double over_s(int self, WaitFor what, From from) const;
  /// Returns whether this rank waits for a dead one without learning of its death.
  bool waits_for_dead(int self, WaitFor what, From from) const;
  /// Returns a rank that has yet to take a message of `self`.
  int taker(int self) const { return end(self).untaken.begin()->first; }

  /// Records the death of the rank on this machine: some of what it sent may be lost.
  void died(const SimulatedMachine& machine, Random& order);

 private:
  struct Parcel {
    std::shared_ptr<const Message> message;
    double arrival_s;
    bool held;  // its sender keeps it until it is taken, as MPI keeps large messages
  };
  struct Revocation {
    int by;
    double arrival_s;
  };
  struct End {
    SimulatedMachine* machine;
    std::map<From, std::deque<Parcel>> inbox;
    std::map<From, double> last_arrival_s;
    std::map<int, int> untaken;  // number of its held messages that others have not taken, by receiver
    int last_taker = 0;
    double taken_s = 0;  // when the last of its held messages was taken
    double entered_s = kNotYet;
    double finished_s = kNotYet;
    double shrink_called_s = kNotYet;  // when it called shrink()
    std::vector<Revocation> revoked;
    bool lost = false;  // it knows of a loss: every call throws
    bool lives() const { return machine->live(); }
    double arrived_s(WaitFor point) const { return point == WaitFor::entered ? entered_s : finished_s; }
  };

  End& end(int rank) { return ends_[static_cast<std::size_t>(rank)]; }
  const End& end(int rank) const { return ends_[static_cast<std::size_t>(rank)]; }
  bool coin(int self, int other, std::uint64_t about) const;
  double noticed_s(int self, int other) const;
  double revoked_s(int self) const;
  double all_arrived_s(WaitFor point) const;
  double shrunk_s(int self) const;
  void check(int self);
  [[noreturn]] void lose(int self, int rank);

  const Simulation& simulation_;
  std::uint64_t timing_;
  std::vector<End> ends_;
  std::shared_ptr<Connections> shrunk_;
  std::vector<int> survivors_;
  double shrunk_at_s_ = 0;
};

}  // namespace motes::comm::simulation
