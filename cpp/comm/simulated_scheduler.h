// Runs simulated ranks as threads, one at a time, in an order drawn from a seed.
#pragma once

#include <semaphore.h>

#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "comm/simulated_connections.h"
#include "comm/simulated_ranks.h"

namespace motes::comm::simulation {

/// Lets one thread wait for another. Memory written before give() is visible after await().
class Signal {
 public:
  Signal() { sem_init(&semaphore_, 0, 0); }
  ~Signal() { sem_destroy(&semaphore_); }
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;

  void give() { sem_post(&semaphore_); }
  void await() {
    while (sem_wait(&semaphore_) != 0) {  // interrupted
    }
  }

 private:
  sem_t semaphore_;
};

class Scheduler {
 public:
  Scheduler(const Simulation& simulation, const std::function<void(int self)>& body);
  SimulatedRun run();

  int size() const { return static_cast<int>(ranks_.size()); }
  SimulatedMachine& machine(int number) { return rank(number).machine; }

  /// The connections among all ranks.
  const std::shared_ptr<Connections>& all() const { return connections_.front(); }
  /// Informs these connections of deaths, too, from now on.
  void keep(const std::shared_ptr<Connections>& connections);

  /// Marks a point at which another rank may continue. Throws if the run has ended or if this rank dies here.
  void point(int self, const char* what, int other, const char* phase, Simulation::Death::At at = {});

  /// Sets what pause() waits for. `as`: this rank's number among the connections.
  void will_wait(int self, const Connections& connections, int as, WaitFor what, From from = {});
  void pause(int self, double until_s);

 private:
  struct Rank {
    enum class State : std::uint8_t { ready, waiting, returned, dead };

    State state = State::ready;
    SimulatedMachine machine;
    const Connections* among = nullptr;  // what it waits for
    int as = 0;
    WaitFor what = WaitFor::none;
    From from{};
    std::uint64_t points = 0;
    std::uint64_t sends = 0;
    std::uint64_t shrinks = 0;
    std::uint64_t priority = 0;
    Signal turn;

    bool over() const { return state == State::returned || state == State::dead; }
  };

  Rank& rank(int number) { return ranks_[static_cast<std::size_t>(number)]; }
  const Rank& rank(int number) const { return ranks_[static_cast<std::size_t>(number)]; }
  void live(int self);
  void hand_over(int self);
  int next();
  double over_s(const Rank& rank) const;
  bool can_continue(const Rank& rank) const;
  void end(std::exception_ptr failure);
  void check_ended() const;
  void die(int self);
  std::string deadlock() const;
  std::string waits(int self) const;
  void note(int self, const char* what, int other, const char* phase);

  const Simulation simulation_;
  const std::function<void(int self)>& body_;
  std::deque<Rank> ranks_;
  std::vector<std::shared_ptr<Connections>> connections_;
  Random order_;
  bool by_priority_ = false;
  std::vector<int> candidates_;
  SimulatedRun happened_;
  bool ended_ = false;
  std::string deadlock_;
  std::exception_ptr failure_;

  Signal all_done_;
};

}  // namespace motes::comm::simulation
