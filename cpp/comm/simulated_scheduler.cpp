#include "comm/simulated_scheduler.h"

#include <sched.h>

#include <algorithm>
#include <stdexcept>
#include <thread>
#include <utility>

#include "base/invalid_argument.h"

namespace motes::comm::simulation {
namespace {

constexpr int kMost = 64;
constexpr int kAllWait = -1;
constexpr int kNoneLeft = -2;
constexpr std::uint64_t kEndless = 100'000'000;  // points: no test is meant to run that long

// Neither is a std::exception: a rank's code must not catch it by mistake.
struct RunEnded {};
struct Died {};

// While it exists, pins the calling thread and the threads that it starts to the current processor. Only one rank runs
// at a time, and the next one starts sooner there than on a processor that must be woken.
class OneProcessor {
 public:
#ifdef __linux__
  OneProcessor() {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(std::max(sched_getcpu(), 0)), &one);
    changed_ = sched_getaffinity(0, sizeof before_, &before_) == 0 && sched_setaffinity(0, sizeof one, &one) == 0;
  }
  ~OneProcessor() {
    if (changed_) sched_setaffinity(0, sizeof before_, &before_);
  }

 private:
  cpu_set_t before_;
  bool changed_;
#else
  OneProcessor() {}
  ~OneProcessor() {}
#endif
};

}  // namespace

Scheduler::Scheduler(const Simulation& simulation, const std::function<void(int self)>& body)
    : simulation_(simulation), body_(body), order_(mixed(simulation.seed, 1)) {
  if (simulation.ranks < 1 || simulation.ranks > kMost) {
    throw base::InvalidArgument("ranks", "be 1.." + std::to_string(kMost), std::to_string(simulation.ranks));
  }
  const std::uint64_t timing = simulation.timing_seed.value_or(simulation.seed);
  // Half of the orders let one rank run as long as it can while another starves, which a fair draw hardly ever does.
  by_priority_ = order_.below(2) == 1;
  std::vector<SimulatedMachine*> machines;
  for (int number = 0; number < simulation.ranks; ++number) {
    Rank& made = ranks_.emplace_back();
    made.priority = order_.next();
    made.machine.number = number;
    made.machine.operation_s = 1 / simulation.speed;
    made.machine.variation = simulation.variation;
    made.machine.timing = Random(mixed(timing, 2 + static_cast<std::uint64_t>(number)));
    machines.push_back(&made.machine);
  }
  connections_.push_back(std::make_shared<Connections>(simulation_, std::move(machines), false));
}

SimulatedRun Scheduler::run() {
  const OneProcessor here;
  std::vector<std::thread> threads;
  for (int number = 0; number < size(); ++number) threads.emplace_back([this, number] { live(number); });
  rank(next()).turn.give();
  all_done_.await();
  for (std::thread& thread : threads) thread.join();
  if (failure_) std::rethrow_exception(failure_);
  for (int number = 0; number < size(); ++number) {
    happened_.clocks_s.push_back(machine(number).clock_s);
    if (!machine(number).live()) happened_.dead.push_back(number);
  }
  return std::move(happened_);
}

// Runs a rank's thread, from its first turn to its last.
void Scheduler::live(int self) {
  rank(self).turn.await();
  set_time_source(&machine(self));
  auto last = Rank::State::returned;
  try {
    check_ended();
    body_(self);
  } catch (const RunEnded&) {
    last = Rank::State::returned;  // counts as a normal return
  } catch (const Died&) {
    last = Rank::State::dead;
  } catch (...) {
    end(std::current_exception());
  }
  set_time_source(nullptr);
  rank(self).state = last;
  if (last == Rank::State::dead) die(self);
  hand_over(self);
}

void Scheduler::keep(const std::shared_ptr<Connections>& connections) {
  if (std::find(connections_.begin(), connections_.end(), connections) != connections_.end()) return;
  connections_.push_back(connections);
}

void Scheduler::will_wait(int self, const Connections& connections, int as, WaitFor what, From from) {
  Rank& waiting = rank(self);
  waiting.among = &connections;
  waiting.as = as;
  waiting.what = what;
  waiting.from = from;
}

// Advances this rank's time to the answer or to `until_s`, whichever comes first. The answer's time may depend only on
// the other rank's clock, not on the order of events, so this waits until the other rank has come that far.
void Scheduler::pause(int self, double until_s) {
  Rank& waits = rank(self);
  waits.state = Rank::State::waiting;
  hand_over(self);
  waits.state = Rank::State::ready;
  check_ended();
  waits.machine.clock_s = std::max(waits.machine.clock_s, std::min(until_s, over_s(waits)));
}

double Scheduler::over_s(const Rank& rank) const {
  return rank.among == nullptr ? 0 : rank.among->over_s(rank.as, rank.what, rank.from);
}

// Returns whether a waiting rank can continue: the answer is known, or the awaited rank is dead and only time passes.
bool Scheduler::can_continue(const Rank& rank) const {
  if (over_s(rank) < kNever) return true;
  return !simulation_.survives && rank.among->waits_for_dead(rank.as, rank.what, rank.from);
}

void Scheduler::point(int self, const char* what, int other, const char* phase, Simulation::Death::At at) {
  using At = Simulation::Death::At;
  check_ended();
  Rank& runs = rank(self);
  ++runs.points;
  if (at == At::send) ++runs.sends;
  if (at == At::shrink) ++runs.shrinks;
  for (const Simulation::Death& death : simulation_.deaths) {
    const bool here = death.at == At::point || death.at == at;
    const std::uint64_t count = death.at == At::send ? runs.sends : death.at == At::shrink ? runs.shrinks : runs.points;
    const bool now = death.rank == self && here && death.point == count;
    if (now) throw Died{};  // NOLINT(bugprone-std-exception-baseclass)
  }
  if (++happened_.points > kEndless) throw std::runtime_error("the simulated ranks do not finish");
  hand_over(self);
  check_ended();
  note(self, what, other, phase);
}

// Lets the next rank run, and returns when it is this one's turn again.
void Scheduler::hand_over(int self) {
  int chosen = next();
  if (chosen == kAllWait) {
    deadlock_ = deadlock();
    end(std::make_exception_ptr(Deadlock(deadlock_)));
    chosen = next();
  }
  if (chosen == self) return;
  if (chosen == kNoneLeft) return all_done_.give();
  const bool last = rank(self).over();  // asked before another rank runs
  rank(chosen).turn.give();
  if (!last) rank(self).turn.await();
}

// Returns the rank that runs next; kAllWait if all remaining ranks wait; kNoneLeft if none remains.
int Scheduler::next() {
  candidates_.clear();
  bool left = false;
  for (int number = 0; number < size(); ++number) {
    const Rank& each = rank(number);
    if (each.over()) continue;
    left = true;
    if (ended_ || each.state == Rank::State::ready || can_continue(each)) candidates_.push_back(number);
  }
  if (candidates_.empty()) return left ? kAllWait : kNoneLeft;
  if (ended_) return candidates_.front();
  if (!by_priority_) return candidates_[order_.below(candidates_.size())];
  const int first = *std::max_element(candidates_.begin(), candidates_.end(),
                                      [&](int a, int b) { return rank(a).priority < rank(b).priority; });
  if (order_.below(8) == 0) rank(first).priority = order_.next();
  return first;
}

void Scheduler::end(std::exception_ptr failure) {
  if (ended_) return;
  ended_ = true;
  failure_ = std::move(failure);
}

void Scheduler::check_ended() const {
  if (!ended_) return;
  if (!deadlock_.empty()) throw Deadlock(deadlock_);
  throw RunEnded{};  // NOLINT(bugprone-std-exception-baseclass)
}

void Scheduler::die(int self) {
  SimulatedMachine& dead = machine(self);
  dead.died_s = dead.clock_s;
  for (const auto& connections : connections_) connections->died(dead, order_);
  note(self, "dies", self, "");
}

std::string Scheduler::deadlock() const {
  std::string text = "deadlock, all ranks wait:";
  for (int number = 0; number < size(); ++number) text += (number == 0 ? " " : "; ") + waits(number);
  return text;
}

std::string Scheduler::waits(int self) const {
  const Rank& waiting = rank(self);
  const std::string who = "rank " + std::to_string(self);
  if (waiting.state == Rank::State::returned) return who + " has returned";
  if (waiting.state == Rank::State::dead) return who + " is dead";
  const auto named = [&](int other) {
    const int number = waiting.among->machine(other).number;
    const bool returned = rank(number).state == Rank::State::returned;
    return "rank " + std::to_string(number) + (returned ? ", which has returned" : "");
  };
  switch (waiting.what) {
    case WaitFor::message:
      return who + " waits for " + name(waiting.from.second) + " from " + named(waiting.from.first);
    case WaitFor::sent: return who + " waits until its message is taken by " + named(waiting.among->taker(waiting.as));
    case WaitFor::entered: return who + " waits for all to enter";
    case WaitFor::shrunk: return who + " waits for all living ranks to shrink";
    default: return who + " waits for all to finish";
  }
}

void Scheduler::note(int self, const char* what, int other, const char* phase) {
  std::uint64_t word = static_cast<std::uint64_t>(self) << 32 | static_cast<std::uint64_t>(other);
  for (const char* text : {what, phase}) {
    for (; *text != '\0'; ++text) word = word * 131 + static_cast<unsigned char>(*text);
  }
  happened_.fingerprint = mixed(happened_.fingerprint, word);
  if (!simulation_.trace) return;
  std::string event = std::to_string(self) + " " + what;
  if (*phase != '\0') event += std::string(" ") + phase;
  if (other != self) event += std::string(*what == 's' ? " to " : " from ") + std::to_string(other);
  happened_.events.push_back(std::move(event));
}

}  // namespace motes::comm::simulation
