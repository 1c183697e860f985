#include "engine/balance/neighbours.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "base/fields.h"
#include "base/invalid_argument.h"
#include "engine/balance/balance.h"
#include "engine/balance/donate.h"

namespace motes::engine {

using balance::Load;
using comm::Message;
using comm::Phase;

namespace {

// Returns this calculator's load after the exchange, as the manager would compute it.
Load load_of(const Population& here) {
  const std::uint64_t processed = here.tally.at_start + here.tally.created;
  return {here.store.size(), balance::rescaled(here.tally.compute_s, processed, here.store.size()), here.speeds.of(0),
          here.speeds.error(0)};
}

// Returns this calculator's load, summed over all systems that share these domains.
Load own_load(const Script& script, const Calculator& calculator, std::size_t system, bool exchanged) {
  std::vector<std::vector<Load>> loads;
  for (const std::size_t i : script.sharing(system)) {
    const Population& here = *calculator.populations[i];
    loads.push_back({exchanged ? load_of(here) : here.expected});
  }
  return loads.size() == 1 ? loads[0][0] : balance::sum_of(loads)[0];
}

// Returns how many particles this calculator gives to the other, by their loads.
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

// Exchanges loads with the partners; returns what this calculator gives to them. A failed calculator sends no loads,
// and no particles move between it and its partners.
std::vector<Request> compare(Rank& rank, const Round& round, const std::vector<std::size_t>& systems,
                             const std::vector<Load>& own, const std::vector<std::int32_t>& partners) {
  Session& session = rank.session;
  const balance::Policy& policy = *rank.settings.policy;
  for (const std::int32_t other : partners) session.comm().await(session.rank_of(other), Phase::loads);
  for (const std::int32_t other : partners) {
    Message message;
    if (!session.failed()) base::write_fields(own, message.bytes());
    session.comm().post(session.rank_of(other), Phase::loads, session.stamp(round), std::move(message), 0,
                        session.failed());
  }
  std::vector<Request> requests;
  for (const std::int32_t other : partners) {
    const Message message = session.comm().expect(session.rank_of(other), Phase::loads, session.stamp(round));
    if (message.header().failed != 0) continue;
    session.work("balancer " + policy.name(), [&] {
      base::Reader in = message.reader();
      std::vector<Load> theirs;
      base::read_fields(in, theirs);
      if (theirs.size() != systems.size())
        throw std::runtime_error("a message has the loads of a different number of systems");
      const std::vector<std::uint64_t> counts = counts_between(policy, session.calculator(), other, own, theirs);
      const auto kind = other < session.calculator() ? Request::Kind::give_left : Request::Kind::give_right;
      for (std::size_t k = 0; k < counts.size(); ++k) {
        if (counts[k] > 0) requests.push_back({static_cast<std::int32_t>(systems[k]), kind, counts[k]});
      }
    });
  }
  return requests;
}

// Returns whether particles are still migrating to this calculator across the same cut. It does not have them yet, and
// would give the same number back.
bool comes_back(const Script& script, const Request& request, int self) {
  const bool right = request.kind == Request::Kind::give_right;
  const int cut = right ? self : self - 1;
  return std::any_of(script.moved_cuts.begin(), script.moved_cuts.end(), [&](const NewCut& moved) {
    return static_cast<std::int32_t>(moved.system) == request.system && static_cast<int>(moved.cut) == cut &&
           (moved.given < 0) == right;
  });
}

// Finds the cut for a gift of this donor. As it may give to both sides, each gets at most half of its particles;
// otherwise its two cuts could cross.
Decision decide(const Rank& rank, const Script& script, const Calculator& calculator, Request request) {
  const auto system = static_cast<std::size_t>(request.system);
  const bool right = request.kind == Request::Kind::give_right;
  const int sign = right ? 1 : -1;
  const int cut = right ? rank.session.calculator() : rank.session.calculator() - 1;
  Decision decision;
  decision.ordered = sign * static_cast<std::int64_t>(request.count);
  std::uint64_t here = 0;
  for (const std::size_t i : script.sharing(system)) here += calculator.populations[i]->store.size();
  request.count = std::min(request.count, here / 2);
  const balance::Gift gift = propose(rank, script, calculator, request).gift;
  decision.cut = {static_cast<std::uint32_t>(system), static_cast<std::uint32_t>(cut), gift.cut,
                  sign * static_cast<std::int64_t>(gift.count)};
  return decision;
}

void check_slabs(const Rank& rank, const Script& script, const std::vector<std::size_t>& systems) {
  for (const std::size_t i : systems) {
    const recording::SystemDefinition& definition = script.systems[i]->definition;
    if (definition.axes.row()) continue;
    throw base::InvalidArgument("domains", "be slabs",
                                "those of '" + definition.name + "', axis " + domains::name_of(definition.axes),
                                rank.settings.policy->name());
  }
}

}  // namespace

std::vector<Request> decide_with_neighbours(Rank& rank, const Script& script, const Calculator& calculator,
                                            const Round& round, const std::vector<std::size_t>& systems,
                                            const std::vector<std::int32_t>& partners) {
  std::vector<Load> own;
  for (const std::size_t i : systems) own.push_back(own_load(script, calculator, i, true));
  return compare(rank, round, systems, own, partners);
}

bool compare_alone(const Rank& rank, const Script& script, const Round& round) {
  return balances(rank, script) && rank.settings.policy->unmanaged() && &round == &script.rounds.back();
}

std::uint64_t expected_of(const Script& script, std::size_t system, int calculator, std::uint64_t alive) {
  auto expected = static_cast<std::int64_t>(alive);
  for (const NewCut& cut : script.moved_cuts) {
    if (cut.system != system) continue;
    if (static_cast<int>(cut.cut) == calculator) expected -= cut.given;
    if (static_cast<int>(cut.cut) + 1 == calculator) expected += cut.given;
  }
  return static_cast<std::uint64_t>(std::max<std::int64_t>(expected, 0));
}

std::vector<Decision> decide_alone(Rank& rank, const Script& script, const Calculator& calculator, const Round& round) {
  Session& session = rank.session;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::balance, "compare loads");
  const std::string what = "balancer " + rank.settings.policy->name();
  std::vector<std::size_t> systems;
  std::vector<Load> own;
  session.work(what, [&] {
    systems = systems_to_balance(rank, script, round);
    check_slabs(rank, script, systems);
    for (const std::size_t i : systems) own.push_back(own_load(script, calculator, i, false));
  });
  std::vector<std::int32_t> partners;
  const int self = session.calculator();
  if (self > 0) partners.push_back(self - 1);
  if (self + 1 < static_cast<int>(session.calculators())) partners.push_back(self + 1);
  const std::vector<Request> requests = compare(rank, round, systems, own, partners);
  std::vector<Decision> decisions;
  session.work(what, [&] {
    for (const Request& request : requests) {
      if (!comes_back(script, request, self)) decisions.push_back(decide(rank, script, calculator, request));
    }
  });
  return decisions;
}

void take_new_cuts(Rank& rank, Script& script, const Calculator& calculator) {
  script.moved_cuts = std::exchange(script.new_cuts, {});
  rank.session.work("balance", [&] {
    std::map<std::size_t, std::vector<float>> cuts;
    for (const NewCut& cut : script.moved_cuts) {
      const auto [of_system, is_new] = cuts.try_emplace(cut.system);
      if (is_new) of_system->second = script.systems.at(cut.system)->domains.cuts();
      of_system->second.at(cut.cut) = cut.at;
    }
    for (auto& [system, after] : cuts) {
      script.divide(system, script.systems[system]->domains.with(std::move(after)));
      // Particles may be outside their domain now; they migrate in the next exchange.
      for (const std::size_t i : script.sharing(system)) calculator.populations[i]->moved = true;
    }
  });
}

}  // namespace motes::engine
