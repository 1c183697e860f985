#include "frame/neighbours.h"

#include <algorithm>
#include <stdexcept>

#include "particles/fields.h"

namespace motes::frame {

using balance::Load;
using comm::Message;
using comm::Phase;

namespace {

// This calculator's, as the manager would see it.
Load load_of(const Population& here) {
  const std::uint64_t processed = here.tally.at_start + here.tally.created;
  return {here.store.size(), balance::rescaled(here.tally.compute_s, processed, here.store.size()), here.speeds.of(0),
          here.speeds.error(0)};
}

// The same of all systems that share these domains.
Load own_load(const Script& script, const Calculator& calculator, std::size_t system) {
  std::vector<std::vector<Load>> loads;
  for (const std::size_t i : script.sharing(system)) loads.push_back({load_of(*calculator.populations[i])});
  return loads.size() == 1 ? loads[0][0] : balance::sum_of(loads)[0];
}

// What this calculator, of two with these loads, has to give.
std::uint64_t to_give(const balance::Policy& policy, int self, int other, const Load& own, const Load& theirs) {
  const balance::Order order = other < self ? policy.between(other, theirs, own) : policy.between(self, own, theirs);
  return order.from == self ? std::min(order.count, own.particles / 2) : 0;
}

std::vector<std::uint64_t> counts_between(const balance::Policy& policy, int self, int other,
                                          const std::vector<Load>& own, const std::vector<Load>& theirs) {
  std::vector<std::uint64_t> counts;
  if (!policy.over_all) {
    for (std::size_t k = 0; k < own.size(); ++k) counts.push_back(to_give(policy, self, other, own[k], theirs[k]));
    return counts;
  }
  std::vector<std::vector<Load>> pairs;
  for (std::size_t k = 0; k < own.size(); ++k) pairs.push_back({own[k], theirs[k]});
  const std::vector<Load> sum = balance::sum_of(pairs);
  if (sum.empty()) return counts;
  const double part = static_cast<double>(to_give(policy, self, other, sum[0], sum[1])) /
                      static_cast<double>(std::max<std::uint64_t>(sum[0].particles, 1));
  for (const Load& load : own) {
    counts.push_back(static_cast<std::uint64_t>(static_cast<double>(load.particles) * part));
  }
  return counts;
}

}  // namespace

std::vector<Request> decide_with_neighbours(Rank& rank, const Script& script, const Calculator& calculator,
                                            const Round& round, const std::vector<std::size_t>& systems,
                                            const std::vector<std::int32_t>& partners) {
  Conversation& talk = rank.talk;
  const balance::Policy& policy = *rank.settings.policy;
  std::vector<Load> own;
  for (const std::size_t i : systems) own.push_back(own_load(script, calculator, i));
  for (const std::int32_t other : partners) {
    Message message;
    particles::write_fields(own, message.bytes());
    talk.comm().post(talk.rank_of(other), Phase::loads, talk.stamp(round), std::move(message));
  }
  std::vector<Request> requests;
  for (const std::int32_t other : partners) {
    const Message message = talk.comm().expect(talk.rank_of(other), Phase::loads, talk.stamp(round));
    talk.work("balancer " + policy.name(), [&] {
      particles::Reader in = message.reader();
      std::vector<Load> theirs;
      particles::read_fields(in, theirs);
      if (theirs.size() != systems.size()) throw std::runtime_error("loads of another number of systems");
      const std::vector<std::uint64_t> counts = counts_between(policy, talk.calculator(), other, own, theirs);
      const auto kind = other < talk.calculator() ? Request::Kind::give_left : Request::Kind::give_right;
      for (std::size_t k = 0; k < counts.size(); ++k) {
        if (counts[k] > 0) requests.push_back({static_cast<std::int32_t>(systems[k]), kind, counts[k]});
      }
    });
  }
  return requests;
}

}  // namespace motes::frame
