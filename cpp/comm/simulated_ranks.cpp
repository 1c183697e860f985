#include "comm/simulated_ranks.h"

#include <sched.h>
#include <semaphore.h>

#include <algorithm>
#include <deque>
#include <exception>
#include <map>
#include <stdexcept>
#include <thread>
#include <utility>

#include "comm/clock.h"

namespace motes::comm {
namespace {

constexpr int kMost = 64;
constexpr int kAllWait = -1;
constexpr int kNoneLeft = -2;
constexpr std::uint64_t kEndless = 100'000'000;  // points: no test means to run that long

// Neither is a std::exception: a rank's code must not catch it by mistake.
struct RunEnded {};
struct Died {};

// SplitMix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators").
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t x = state_ += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  std::size_t below(std::size_t end) { return static_cast<std::size_t>(next() % end); }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

std::uint64_t mixed(std::uint64_t a, std::uint64_t b) { return Random(a * 0x2545f4914f6cdd1du + b).next(); }

// Lets one thread wait for another's word, and hands memory over with it.
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

// Only one of the ranks runs at a time: on one processor the next one starts at once, while another processor would
// have to be woken. While this lives, the calling thread and the threads that it starts stay where it is.
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

// What a rank waits for.
enum class Question : std::uint8_t { none, message, sent, entered, finished };

struct Parcel {
  particles::Bytes bytes;
  double arrival_s;
  bool held;  // its sender keeps it until it is taken, as MPI keeps large messages
};

constexpr double kNotYet = -1;
constexpr double kNever = 1e300;

using From = std::pair<int, Phase>;

struct Rank final : TimeSource {
  enum class State : std::uint8_t { ready, waiting, returned, dead };

  State state = State::ready;
  Question question = Question::none;
  From from{};  // of the message it waits for
  std::uint64_t points = 0;
  std::uint64_t priority = 0;
  Signal turn;
  std::map<From, std::deque<Parcel>> inbox;
  std::map<From, double> last_arrival_s;
  std::map<int, int> untaken;  // its messages that others have not taken, by receiver
  int last_taker = 0;
  double taken_s = 0;  // when the last of them was
  double entered_s = kNotYet;
  double finished_s = kNotYet;

  double clock_s = 0;
  double operation_s = 1e-9;
  double variation = 0;
  Random timing{0};

  bool live() const { return state != State::dead; }
  bool over() const { return state == State::returned || state == State::dead; }
  double varied(double seconds) { return seconds * (1 + variation * (2 * timing.unit() - 1)); }
  double now_s() const override { return clock_s; }
  void spend(double seconds) override { clock_s += std::max(seconds, 0.0); }
  void execute(double operations) override { clock_s += varied(operations * operation_s); }
};

class Scheduler {
 public:
  Scheduler(const Simulation& simulation, const std::function<void(SimulatedRank&)>& body);
  SimulatedRun run();

  int size() const { return static_cast<int>(ranks_.size()); }
  Rank& rank(int number) { return ranks_[static_cast<std::size_t>(number)]; }

  // Each is a point where another rank may go on, and throws where the run has ended.
  void send(int self, int to, Phase phase, particles::Bytes bytes);
  std::optional<particles::Bytes> receive(int self, int from, Phase phase);
  std::optional<int> unsent(int self);
  bool together(int self, Question which);
  void pause(int self, double until_s);

 private:
  void live(int self);
  void point(int self, const char* what, int other, const char* phase);
  void hand_over(int self);
  int next();
  bool answerable(const Rank& rank) const;
  double answer_s(const Rank& rank) const;
  double all_s(double Rank::* came_s) const;
  bool anybody_dead() const;
  void end(std::exception_ptr failure);
  void check_ended() const;
  void die(int self);
  std::string deadlock() const;
  std::string waits(int self) const;
  void note(int self, const char* what, int other, const char* phase);

  const Simulation simulation_;
  const std::function<void(SimulatedRank&)>& body_;
  std::deque<Rank> ranks_;
  Random order_;
  bool by_priority_ = false;
  std::vector<int> candidates_;
  SimulatedRun happened_;
  bool ended_ = false;
  std::string deadlock_;
  std::exception_ptr failure_;

  Signal all_done_;
};

class SimulatedTransport final : public Transport {
 public:
  SimulatedTransport(Scheduler& scheduler, int self) : scheduler_(scheduler), self_(self) {}

  int rank() const override { return self_; }
  int size() const override { return scheduler_.size(); }
  bool entered() override { return scheduler_.together(self_, Question::entered); }
  void send(int to, Phase phase, Message message) override {
    handle(message.header());
    scheduler_.send(self_, to, phase, std::move(message.bytes()));
  }
  void await(int, Phase) override {}
  std::optional<particles::Bytes> receive(int from, Phase phase) override {
    std::optional<particles::Bytes> bytes = scheduler_.receive(self_, from, phase);
    if (bytes && bytes->size() >= sizeof(Header)) handle(particles::Reader(bytes->view()).get<Header>());
    return bytes;
  }
  std::optional<int> unsent() override { return scheduler_.unsent(self_); }
  bool finished() override { return scheduler_.together(self_, Question::finished); }
  void pause(int, double until_s) override { scheduler_.pause(self_, until_s); }
  void weigh(Weights weights) override { weights_ = weights; }

 private:
  // The time that a message takes at one end.
  void handle(const Header& header) const {
    const double bytes = static_cast<double>(sizeof header + header.payload_bytes);
    execute(weights_.message + weights_.byte * bytes * (header.count > 0 ? weights_.scale : 1));
  }

  Scheduler& scheduler_;
  int self_;
  Weights weights_;
};

class Self final : public SimulatedRank {
 public:
  Self(Scheduler& scheduler, int self) : scheduler_(scheduler), self_(self) {}
  int rank() const override { return self_; }
  std::unique_ptr<Transport> transport() override { return std::make_unique<SimulatedTransport>(scheduler_, self_); }
  bool alive(int rank) const override { return scheduler_.rank(rank).live(); }

 private:
  Scheduler& scheduler_;
  int self_;
};

Scheduler::Scheduler(const Simulation& simulation, const std::function<void(SimulatedRank&)>& body)
    : simulation_(simulation), body_(body), order_(mixed(simulation.seed, 1)) {
  if (simulation.ranks < 1 || simulation.ranks > kMost) {
    throw std::invalid_argument("ranks must be 1.." + std::to_string(kMost) + ", got " +
                                std::to_string(simulation.ranks));
  }
  const std::uint64_t timing = simulation.timing_seed.value_or(simulation.seed);
  // One order in two lets a rank run as long as it can, while another starves: what a fair lottery hardly ever draws.
  by_priority_ = order_.below(2) == 1;
  for (int number = 0; number < simulation.ranks; ++number) {
    Rank& rank = ranks_.emplace_back();
    rank.priority = order_.next();
    rank.operation_s = 1 / simulation.speed;
    rank.variation = simulation.variation;
    rank.timing = Random(mixed(timing, 2 + static_cast<std::uint64_t>(number)));
  }
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
    happened_.clocks_s.push_back(rank(number).clock_s);
    if (!rank(number).live()) happened_.dead.push_back(number);
  }
  return std::move(happened_);
}

// A rank's thread, from its first turn to its last.
void Scheduler::live(int self) {
  rank(self).turn.await();
  set_time_source(&rank(self));
  auto last = Rank::State::returned;
  try {
    check_ended();
    Self me(*this, self);
    body_(me);
  } catch (const RunEnded&) {
    last = Rank::State::returned;  // as if it had nothing more to say
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

void Scheduler::send(int self, int to, Phase phase, particles::Bytes bytes) {
  point(self, "sends", to, name(phase));
  Rank& sender = rank(self);
  Rank& receiver = rank(to);
  if (to == self) throw std::logic_error("a transport does not send to its own rank");
  const double transit_s =
      sender.varied(simulation_.latency_s) + sender.varied(static_cast<double>(bytes.size()) / simulation_.bandwidth);
  double& last_s = receiver.last_arrival_s[{self, phase}];
  last_s = std::max(last_s, sender.clock_s + transit_s);
  const bool held = sender.timing.below(2) == 1;
  if (held) ++sender.untaken[to];
  receiver.inbox[{self, phase}].push_back({std::move(bytes), last_s, held});
}

std::optional<particles::Bytes> Scheduler::receive(int self, int from, Phase phase) {
  point(self, "polls", from, name(phase));
  Rank& receiver = rank(self);
  receiver.question = Question::message;
  receiver.from = {from, phase};
  std::deque<Parcel>& parcels = receiver.inbox[receiver.from];
  if (parcels.empty() || parcels.front().arrival_s > receiver.clock_s) return std::nullopt;
  Parcel parcel = std::move(parcels.front());
  parcels.pop_front();
  if (parcel.held) {
    Rank& sender = rank(from);
    if (--sender.untaken[self] == 0) sender.untaken.erase(self);
    if (receiver.clock_s >= sender.taken_s) {
      sender.taken_s = receiver.clock_s;
      sender.last_taker = self;
    }
  }
  return std::move(parcel.bytes);
}

std::optional<int> Scheduler::unsent(int self) {
  point(self, "asks what has left", self, "");
  Rank& sender = rank(self);
  sender.question = Question::sent;
  if (!sender.untaken.empty()) return sender.untaken.begin()->first;
  if (sender.clock_s < sender.taken_s) return sender.last_taker;
  return std::nullopt;
}

bool Scheduler::together(int self, Question which) {
  point(self, which == Question::entered ? "enters" : "finishes", self, "");
  Rank& asks = rank(self);
  double& came_s = which == Question::entered ? asks.entered_s : asks.finished_s;
  if (came_s == kNotYet) came_s = asks.clock_s;
  asks.question = which;
  return asks.clock_s >= answer_s(asks);
}

// Time passes until the answer is there, or until the caller looks around. When that is depends on the other rank's
// time alone, not on who runs when: so the wait goes on until the other rank has come so far.
void Scheduler::pause(int self, double until_s) {
  Rank& waits = rank(self);
  waits.state = Rank::State::waiting;
  hand_over(self);
  waits.state = Rank::State::ready;
  check_ended();
  waits.clock_s = std::max(waits.clock_s, std::min(until_s, answer_s(waits)));
}

// Whether a waiting rank has something to do: the answer is known, or a death lets its time pass.
bool Scheduler::answerable(const Rank& rank) const {
  const auto dead = [&](int number) { return !ranks_[static_cast<std::size_t>(number)].live(); };
  switch (rank.question) {
    case Question::message: return answer_s(rank) < kNever || dead(rank.from.first);
    case Question::sent:
      return std::all_of(rank.untaken.begin(), rank.untaken.end(), [&](const auto& of) { return dead(of.first); });
    default: return answer_s(rank) < kNever || anybody_dead();
  }
}

// The time from which on the answer is yes, if all that it takes has happened.
double Scheduler::answer_s(const Rank& rank) const {
  switch (rank.question) {
    case Question::message: {
      const auto found = rank.inbox.find(rank.from);
      return found == rank.inbox.end() || found->second.empty() ? kNever : found->second.front().arrival_s;
    }
    case Question::sent: return rank.untaken.empty() ? rank.taken_s : kNever;
    case Question::entered: return all_s(&Rank::entered_s);
    case Question::finished: return all_s(&Rank::finished_s);
    case Question::none: break;
  }
  return 0;
}

// When the last of all ranks came to a place.
double Scheduler::all_s(double Rank::* came_s) const {
  double latest_s = 0;
  for (const Rank& each : ranks_) {
    if (each.*came_s == kNotYet) return kNever;
    latest_s = std::max(latest_s, each.*came_s);
  }
  return latest_s;
}

bool Scheduler::anybody_dead() const {
  return std::any_of(ranks_.begin(), ranks_.end(), [](const Rank& each) { return !each.live(); });
}

void Scheduler::point(int self, const char* what, int other, const char* phase) {
  check_ended();
  Rank& runs = rank(self);
  ++runs.points;
  for (const Simulation::Death& death : simulation_.deaths) {
    if (death.rank == self && death.point == runs.points) throw Died{};  // NOLINT(bugprone-std-exception-baseclass)
  }
  if (++happened_.points > kEndless) throw std::runtime_error("the simulated ranks do not come to an end");
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

// The rank that runs next; or that all that are left wait; or that none is left.
int Scheduler::next() {
  candidates_.clear();
  bool left = false;
  for (int number = 0; number < size(); ++number) {
    const Rank& each = rank(number);
    if (each.over()) continue;
    left = true;
    if (ended_ || each.state == Rank::State::ready || answerable(each)) candidates_.push_back(number);
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

// Of the messages that it still held, the last ones of each kind are lost.
void Scheduler::die(int self) {
  for (Rank& receiver : ranks_) {
    for (auto& [from, parcels] : receiver.inbox) {
      if (from.first != self || parcels.empty()) continue;
      std::size_t kept = order_.below(parcels.size() + 1);
      while (kept < parcels.size() && !parcels[kept].held) ++kept;
      parcels.erase(parcels.begin() + static_cast<std::ptrdiff_t>(kept), parcels.end());
    }
  }
  note(self, "dies", self, "");
}

std::string Scheduler::deadlock() const {
  std::string text = "all ranks wait for ever:";
  for (int number = 0; number < size(); ++number) text += (number == 0 ? " " : "; ") + waits(number);
  return text;
}

std::string Scheduler::waits(int self) const {
  const auto of = [&](int number) -> const Rank& { return ranks_[static_cast<std::size_t>(number)]; };
  const auto named = [&](int number) {
    return "rank " + std::to_string(number) + (of(number).state == Rank::State::returned ? ", which has returned" : "");
  };
  const std::string who = "rank " + std::to_string(self);
  const Rank& rank = of(self);
  if (rank.state == Rank::State::returned) return who + " has returned";
  if (rank.state == Rank::State::dead) return who + " is dead";
  switch (rank.question) {
    case Question::message: return who + " waits for " + name(rank.from.second) + " from " + named(rank.from.first);
    case Question::sent: return who + " waits until its message is taken by " + named(rank.untaken.begin()->first);
    case Question::entered: return who + " waits for all to enter";
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

}  // namespace

SimulatedRun simulate(const Simulation& simulation, const std::function<void(SimulatedRank&)>& body) {
  return Scheduler(simulation, body).run();
}

}  // namespace motes::comm
