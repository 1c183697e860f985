#include "comm/simulated_connections.h"

#include <algorithm>
#include <stdexcept>

namespace motes::comm::simulation {
namespace {

// The longest time that news of a loss or revocation takes, in latencies of a message: long enough for much to happen.
constexpr double kNews = 200;

}  // namespace

Connections::Connections(const Simulation& simulation, std::vector<SimulatedMachine*> members, bool entered)
    : simulation_(simulation), timing_(mixed(simulation.timing_seed.value_or(simulation.seed), 1'000'003)) {
  for (SimulatedMachine* const machine : members) {
    End& made = ends_.emplace_back();
    made.machine = machine;
    if (entered) made.entered_s = 0;
  }
}

void Connections::send(int self, int to, Phase phase, std::shared_ptr<const Message> message) {
  check(self);
  if (to == self) throw std::logic_error("a transport does not send to its own rank");
  SimulatedMachine& sender = machine(self);
  if (sender.clock_s >= noticed_s(self, to)) lose(self, to);
  End& receiver = end(to);
  const double transit_s = sender.varied(simulation_.latency_s) +
                           sender.varied(static_cast<double>(message->bytes().size()) / simulation_.bandwidth);
  double& last_s = receiver.last_arrival_s[{self, phase}];
  last_s = std::max(last_s, sender.clock_s + transit_s);
  const bool held = sender.timing.below(2) == 1;
  if (held) ++end(self).untaken[to];
  receiver.inbox[{self, phase}].push_back({std::move(message), last_s, held});
}

std::optional<base::Bytes> Connections::receive(int self, From from) {
  check(self);
  End& receiver = end(self);
  const double now_s = receiver.machine->clock_s;
  const bool knows = now_s >= noticed_s(self, from.first);
  std::deque<Parcel>& parcels = receiver.inbox[from];
  // Messages of a lost rank that have arrived may still be taken, or not.
  if (knows && (parcels.empty() || coin(self, from.first, 1))) lose(self, from.first);
  if (parcels.empty() || parcels.front().arrival_s > now_s) return std::nullopt;
  const Parcel parcel = std::move(parcels.front());
  parcels.pop_front();
  if (parcel.held) {
    End& sender = end(from.first);
    if (--sender.untaken[self] == 0) sender.untaken.erase(self);
    if (now_s >= sender.taken_s) {
      sender.taken_s = now_s;
      sender.last_taker = self;
    }
  }
  base::Bytes bytes;
  bytes.put_raw(parcel.message->bytes().data(), parcel.message->bytes().size());
  return bytes;
}

std::optional<int> Connections::unsent(int self) {
  check(self);
  const End& sender = end(self);
  for (const auto& [to, messages] : sender.untaken) {
    if (sender.machine->clock_s >= noticed_s(self, to)) lose(self, to);
  }
  if (!sender.untaken.empty()) return sender.untaken.begin()->first;
  if (sender.machine->clock_s < sender.taken_s) return sender.last_taker;
  return std::nullopt;
}

bool Connections::arrive_at(int self, WaitFor point) {
  End& own = end(self);
  const double now_s = own.machine->clock_s;
  if (own.arrived_s(point) == kNotYet) {
    check(self);
    (point == WaitFor::entered ? own.entered_s : own.finished_s) = now_s;
  }
  // When all have come, no news changes that.
  if (all_arrived_s(point) < kNever) return now_s >= all_arrived_s(point);
  check(self);
  for (int other = 0; other < size(); ++other) {
    if (end(other).arrived_s(point) == kNotYet && now_s >= noticed_s(self, other)) lose(self, other);
  }
  return false;
}

void Connections::revoke(int self) {
  End& own = end(self);
  own.lost = true;
  for (int other = 0; other < size(); ++other) {
    if (other == self) continue;
    const double u = Random(mixed(mixed(timing_, 7 + own.revoked.size()), 64 * self + other)).unit();
    end(other).revoked.push_back({self, own.machine->clock_s + simulation_.latency_s * (0.5 + kNews * u)});
  }
}

std::shared_ptr<Connections> Connections::shrink(int self, std::vector<int>& survivors) {
  End& own = end(self);
  if (all_arrived_s(WaitFor::finished) < kNever) throw CommError("the other ranks have finished");
  if (own.shrink_called_s == kNotYet) own.shrink_called_s = own.machine->clock_s;
  const double over_s = shrunk_s(self);
  if (own.machine->clock_s < over_s) return nullptr;
  if (!shrunk_) {
    std::vector<SimulatedMachine*> members;
    for (int rank = 0; rank < size(); ++rank) {
      // A rank that came and has died since may still be included; its loss is noticed later.
      const End& each = end(rank);
      if (!each.lives() && (each.shrink_called_s == kNotYet || coin(rank, rank, 2))) continue;
      members.push_back(each.machine);
      survivors_.push_back(rank);
    }
    shrunk_ = std::make_shared<Connections>(simulation_, std::move(members), true);
    shrunk_at_s_ = over_s;
  }
  survivors = survivors_;
  return shrunk_;
}

double Connections::over_s(int self, WaitFor what, From from) const {
  const End& own = end(self);
  const auto or_revoked = [&](double seconds) { return std::min(seconds, revoked_s(self)); };
  const auto all_or_loss_s = [&] {
    double first_s = kNever;
    for (int other = 0; other < size(); ++other) {
      if (end(other).arrived_s(what) == kNotYet) first_s = std::min(first_s, noticed_s(self, other));
    }
    return all_arrived_s(what) < kNever ? all_arrived_s(what) : or_revoked(first_s);
  };
  switch (what) {
    case WaitFor::message: {
      const auto found = own.inbox.find(from);
      const bool comes = found != own.inbox.end() && !found->second.empty();
      const bool lost = !comes || coin(self, from.first, 1);  // as receive() decides
      const double arrival_s = comes ? found->second.front().arrival_s : kNever;
      return or_revoked(std::min(arrival_s, lost ? noticed_s(self, from.first) : kNever));
    }
    case WaitFor::sent: {
      if (own.untaken.empty()) return own.taken_s;
      double first_s = kNever;
      for (const auto& [to, messages] : own.untaken) first_s = std::min(first_s, noticed_s(self, to));
      return or_revoked(first_s);
    }
    case WaitFor::entered:
    case WaitFor::finished: return all_or_loss_s();
    case WaitFor::shrunk: return shrunk_s(self);
    case WaitFor::none: break;
  }
  return 0;
}

bool Connections::waits_for_dead(int self, WaitFor what, From from) const {
  const auto dead = [&](int rank) { return !end(rank).lives(); };
  switch (what) {
    case WaitFor::message: return dead(from.first);
    case WaitFor::sent: {
      const auto& untaken = end(self).untaken;
      return std::all_of(untaken.begin(), untaken.end(), [&](const auto& of) { return dead(of.first); });
    }
    default: return std::any_of(ends_.begin(), ends_.end(), [](const End& each) { return !each.lives(); });
  }
}

// Loses, at random, the last messages of each kind that the rank still held, its arrival in finished() and its
// revocations in flight.
void Connections::died(const SimulatedMachine& machine, Random& order) {
  const auto found =
      std::find_if(ends_.begin(), ends_.end(), [&](const End& each) { return each.machine == &machine; });
  if (found == ends_.end()) return;
  const int self = static_cast<int>(found - ends_.begin());
  for (End& receiver : ends_) {
    for (auto& [from, parcels] : receiver.inbox) {
      if (from.first != self || parcels.empty()) continue;
      std::size_t kept = order.below(parcels.size() + 1);
      while (kept < parcels.size() && !parcels[kept].held) ++kept;
      parcels.erase(parcels.begin() + static_cast<std::ptrdiff_t>(kept), parcels.end());
    }
    std::erase_if(receiver.revoked, [&](const Revocation& each) {
      return each.by == self && each.arrival_s > machine.clock_s && order.below(2) == 1;
    });
  }
  if (simulation_.survives && all_arrived_s(WaitFor::finished) == kNever && order.below(2) == 1) {
    found->finished_s = kNotYet;
  }
}

// Returns a random bit that does not depend on when it is asked for.
bool Connections::coin(int self, int other, std::uint64_t about) const {
  const auto pair = static_cast<std::uint64_t>(64 * self + other);
  return (mixed(mixed(timing_, about), pair) & 1) == 1;
}

// Returns when a rank learns that another one is dead.
double Connections::noticed_s(int self, int other) const {
  const SimulatedMachine& dead = machine(other);
  if (dead.live() || !simulation_.survives) return kNever;
  const auto pair = static_cast<std::uint64_t>(64 * machine(self).number + dead.number);
  return dead.died_s + simulation_.latency_s * (0.5 + kNews * Random(mixed(timing_, pair + 1000)).unit());
}

double Connections::revoked_s(int self) const {
  double first_s = kNever;
  for (const Revocation& each : end(self).revoked) first_s = std::min(first_s, each.arrival_s);
  return first_s;
}

// Returns when the last of all ranks came to the point where all enter, or finish; kNever if some have not.
double Connections::all_arrived_s(WaitFor point) const {
  double latest_s = 0;
  for (const End& each : ends_) {
    if (each.arrived_s(point) == kNotYet) return kNever;
    latest_s = std::max(latest_s, each.arrived_s(point));
  }
  return latest_s;
}

// Returns when all surviving ranks have come to shrink() and `self` knows of all deaths.
double Connections::shrunk_s(int self) const {
  if (shrunk_) return shrunk_at_s_;
  double latest_s = 0;
  for (int other = 0; other < size(); ++other) {
    const End& each = end(other);
    if (each.lives() && each.shrink_called_s == kNotYet) return kNever;
    latest_s = std::max(latest_s, each.lives() ? each.shrink_called_s : noticed_s(self, other));
  }
  return latest_s;
}

void Connections::check(int self) {
  if (end(self).lost || machine(self).clock_s >= revoked_s(self)) lose(self, -1);
}

void Connections::lose(int self, int rank) {
  end(self).lost = true;
  throw RankLost(rank);
}

}  // namespace motes::comm::simulation
