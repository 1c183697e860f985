// What is under way between simulated ranks, and when each of them learns of it. Knows time, but not who runs next.
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
enum class Question : std::uint8_t { none, message, sent, entered, finished, shrunk };

using From = std::pair<int, Phase>;

/// The connections among some ranks, who are numbered here by themselves. The first of all, then one for each shrink().
/// Where the simulation survives losses, each function but revoke() and shrink() throws RankLost when the rank that
/// calls knows of one that concerns it.
class Connections {
 public:
  /// `entered`: nobody needs to wait for others to enter.
  Connections(const Simulation& simulation, std::vector<SimulatedMachine*> members, bool entered);

  int size() const { return static_cast<int>(ends_.size()); }
  SimulatedMachine& machine(int rank) const { return *end(rank).machine; }

  void send(int self, int to, Phase phase, std::shared_ptr<const Message> message);
  std::optional<base::Bytes> receive(int self, From from);
  std::optional<int> unsent(int self);
  bool together(int self, Question which);
  void revoke(int self);
  /// The connections among those that live, when all of them have come; null before.
  std::shared_ptr<Connections> shrink(int self, std::vector<int>& survivors);

  /// The time from which on the answer is known: what was asked for, or a loss. kNever: something must happen first.
  double answer_s(int self, Question question, From from) const;
  /// Whether a death, of which nobody tells this rank, lets its time pass.
  bool waits_for_dead(int self, Question question, From from) const;
  /// Whose taking of a message `self` waits for.
  int taker(int self) const { return end(self).untaken.begin()->first; }

  /// The rank on this machine has died: some of what it sent may be lost.
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
    std::map<int, int> untaken;  // its messages that others have not taken, by receiver
    int last_taker = 0;
    double taken_s = 0;  // when the last of them was
    double entered_s = kNotYet;
    double finished_s = kNotYet;
    double came_s = kNotYet;  // to shrink
    std::vector<Revocation> revoked;
    bool lost = false;  // it knows of a loss: every call throws
    bool lives() const { return machine->live(); }
  };

  End& end(int rank) { return ends_[static_cast<std::size_t>(rank)]; }
  const End& end(int rank) const { return ends_[static_cast<std::size_t>(rank)]; }
  bool coin(int self, int other, std::uint64_t about) const;
  double noticed_s(int self, int other) const;
  double revoked_s(int self) const;
  double all_s(double End::* came_s) const;
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
