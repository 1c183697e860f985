// balance (paper 3.2.5): the manager plans from the frame's loads, or neighbours decide by themselves; donors find
// the new cuts; the manager sends all of them with the next frame's births, and waits for donors no sooner than it
// needs to. What is then outside its domain goes to its owner in that frame's exchange: donation needs no messages of
// its own. Where nothing is to be decided nobody says so: the verdict tells who has something to talk about.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "balance/cuts.h"
#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using balance::Load;
using comm::Message;
using comm::Phase;

namespace {

// Bins of a calculator's histogram: many where many particles are, so that a bin holds under a hundredth of a fair
// share, and all histograms together grow with the number of calculators alone.
std::uint64_t bins_for(const std::vector<Load>& loads, std::size_t calculator) {
  double all = 0;
  for (const Load& load : loads) all += static_cast<double>(load.particles);
  const double bins = 512 + 128 * static_cast<double>(loads.size());
  const double part = static_cast<double>(loads[calculator].particles) / std::max(all, 1.0);
  return std::max<std::uint64_t>(8, static_cast<std::uint64_t>(bins * part));
}

std::span<const float> coordinates(const System& system, std::vector<float>& room) {
  const particles::Store& store = *system.store;
  if (const float* x = store.plane(particles::position, system.definition.axis)) return {x, store.size()};
  const auto axis = static_cast<std::size_t>(system.definition.axis);
  room.assign(store.size(), store.uniform_value(particles::position)[axis]);
  return room;
}

}  // namespace

bool Engine::balances() const {
  return in_frame() && options_.policy != nullptr && options_.policy->moves() && cast_.calculators.size() > 1;
}

// Those of this round; where the sum over systems counts, all of them in the frame's last round.
std::vector<std::size_t> Engine::systems_to_balance(const Round& round) const {
  std::vector<std::size_t> found;
  const bool all = options_.policy->over_all;
  if (all && round.last < systems_.size()) return found;
  for (std::size_t i = all ? 0 : round.first; i < round.last; ++i) {
    if (!systems_[i]->waits_for_fit) found.push_back(i);
  }
  return found;
}

// Manager: what each calculator is asked for.
void Engine::plan(const Round& round, std::vector<Orders>& orders) {
  const balance::Policy& policy = *options_.policy;
  const std::vector<std::size_t> systems = systems_to_balance(round);
  balance::Plan whole;
  std::vector<Load> sum;
  if (policy.over_all && !systems.empty()) {
    std::vector<std::vector<Load>> loads;
    for (const std::size_t i : systems) loads.push_back(systems_[i]->loads);
    sum = balance::sum_of(loads);
    System& first = *systems_[systems.front()];
    const balance::Table table{frame_, first.evaluations++, "all", sum, first.domains.cuts()};
    whole = balance::legal(policy.plan(table), table, policy.name());
  }
  for (const std::size_t i : systems) {
    System& s = *systems_[i];
    if (policy.over_all) {
      ask(i, balance::part_of(whole, s.loads, sum), orders);
    } else {
      const balance::Table table{frame_, s.evaluations++, s.definition.name, s.loads, s.domains.cuts()};
      ask(i, balance::legal(policy.plan(table), table, policy.name()), orders);
    }
  }
}

void Engine::ask(std::size_t system, const balance::Plan& plan, std::vector<Orders>& orders) {
  const auto index = static_cast<std::int32_t>(system);
  const bool alone = options_.policy->decentralised();
  if (log_) {
    for (const std::int32_t cut : plan.evaluated) {
      BalanceRow& row = row_of(system, cut);
      if (alone) row.ordered = 0;
    }
  }
  if (alone) return bring_together(plan, orders);
  for (const balance::Order& order : plan.orders) {
    const bool right = order.to > order.from;
    const auto kind = right ? Request::Kind::give_right : Request::Kind::give_left;
    orders[static_cast<std::size_t>(order.from)].requests.push_back({index, kind, order.count});
    const auto count = static_cast<std::int64_t>(order.count);
    row_of(system, std::min(order.from, order.to)).ordered = right ? count : -count;
  }
  if (!plan.shares.empty()) {
    for (std::size_t c = 0; c < orders.size(); ++c) {
      orders[c].requests.push_back({index, Request::Kind::histogram, bins_for(systems_[system]->loads, c)});
    }
  }
  systems_[system]->plan = plan;
}

// Manager: neighbours whose loads it sees to be apart shall compare them. What goes over a cut is theirs to say.
void Engine::bring_together(const balance::Plan& plan, std::vector<Orders>& orders) {
  for (const balance::Order& order : plan.orders) {
    for (const auto& [one, other] : {std::pair{order.from, order.to}, std::pair{order.to, order.from}}) {
      std::vector<std::int32_t>& partners = orders[static_cast<std::size_t>(one)].partners;
      const auto place = std::lower_bound(partners.begin(), partners.end(), other);
      if (place == partners.end() || *place != other) partners.insert(place, other);
    }
  }
}

// The row of a cut that is being looked at; made where there is none yet.
BalanceRow& Engine::row_of(std::size_t system, std::int32_t cut) {
  const auto [found, is_new] = balance_rows_.try_emplace({system, cut});
  BalanceRow& row = found->second;
  if (!is_new) return row;
  const System& s = *systems_[system];
  const auto left = static_cast<std::size_t>(cut);
  row.frame = frame_;
  row.system = s.definition.name;
  row.left_rank = cast_.calculators[left];
  row.right_rank = cast_.calculators[left + 1];
  row.left = s.loads[left];
  row.right = s.loads[left + 1];
  row.cut_before = row.cut_after = s.domains.cuts()[left];
  return row;
}

// All ranks: donors look where their particles are, and tell the manager.
void Engine::balance(Round& round) {
  if (!balances()) return;
  const Timed timed(*this, times_.balance, "balance", name_of(round));
  particles::Bytes proposals;
  if (calculator() >= 0) {
    for (std::size_t i = round.first; !manages() && i < round.last; ++i) {
      System& s = *systems_[i];
      s.speeds.add(calculator(), s.tally.at_start + s.tally.created, s.tally.compute_s, s.tally.created);
    }
    std::vector<Request> requests = std::move(round.orders.requests);
    if (!round.orders.partners.empty()) requests = decide_with_neighbours(round);
    work("balance", [&] {
      for (const Request& request : requests) write(propose(request), proposals);
    });
    if (failure_.failed()) proposals.clear();
  }
  if (!round.verdict.asks) return;
  relay_.say(Phase::proposals, stamp(round), proposals.view(), failure_.failed());
  relay_.hand_up(Phase::proposals, stamp(round));
  // Who was asked answers while other work goes on.
  if (manages()) asked_.push_back({stamp(round), systems_to_balance(round)});
}

// Manager: before it deals births by the new cuts.
void Engine::take_all_proposals() {
  if (!manages() || (asked_.empty() && balance_rows_.empty())) return;
  const Timed timed(*this, times_.balance, "new cuts");
  histograms_.assign(systems_.size(), {});
  for (const Asked& asked : std::exchange(asked_, {})) take_proposals(asked);
  write_balance_rows();
}

// What neighbours tell each other is all that either needs; both come to the same order, and the donor acts on it.
std::vector<Request> Engine::decide_with_neighbours(const Round& round) {
  const std::vector<std::size_t> systems = systems_to_balance(round);
  const std::vector<std::int32_t>& partners = round.orders.partners;
  const int me = calculator();
  std::vector<Load> own;
  for (const std::size_t i : systems) own.push_back(own_load(*systems_[i]));
  for (const std::int32_t other : partners) {
    Message message;
    message.bytes().put_raw(own.data(), own.size() * sizeof(Load));
    comm_->post(cast_.calculators[static_cast<std::size_t>(other)], Phase::loads, stamp(round), std::move(message));
  }
  std::vector<Request> requests;
  for (const std::int32_t other : partners) {
    const Message message =
        comm_->expect(cast_.calculators[static_cast<std::size_t>(other)], Phase::loads, stamp(round));
    work("balancer " + options_.policy->name(), [&] {
      particles::Reader in = message.reader();
      std::vector<Load> theirs;
      for (std::size_t k = 0; k < systems.size(); ++k) theirs.push_back(in.get<Load>());
      const std::vector<Request> some = requests_between(me, other, own, theirs, systems);
      requests.insert(requests.end(), some.begin(), some.end());
    });
  }
  return requests;
}

// What this calculator has to give to a neighbour of each of these systems.
std::vector<Request> Engine::requests_between(int me, int other, const std::vector<Load>& own,
                                              const std::vector<Load>& theirs,
                                              const std::vector<std::size_t>& systems) const {
  const balance::Policy& policy = *options_.policy;
  const auto between = [&](const Load& mine, const Load& his) {
    const balance::Order order = other < me ? policy.between(other, his, mine) : policy.between(me, mine, his);
    return order.from == me ? std::min(order.count, mine.particles / 2) : 0;
  };
  std::vector<std::uint64_t> counts;
  if (policy.over_all) {
    std::vector<std::vector<Load>> pairs;
    for (std::size_t k = 0; k < systems.size(); ++k) pairs.push_back({own[k], theirs[k]});
    const std::vector<Load> sum = balance::sum_of(pairs);
    if (sum.empty()) return {};
    const double part = static_cast<double>(between(sum[0], sum[1])) /
                        static_cast<double>(std::max<std::uint64_t>(sum[0].particles, 1));
    for (const Load& load : own)
      counts.push_back(static_cast<std::uint64_t>(static_cast<double>(load.particles) * part));
  } else {
    for (std::size_t k = 0; k < systems.size(); ++k) counts.push_back(between(own[k], theirs[k]));
  }
  const auto kind = other < me ? Request::Kind::give_left : Request::Kind::give_right;
  std::vector<Request> requests;
  for (std::size_t k = 0; k < systems.size(); ++k) {
    if (counts[k] > 0) requests.push_back({static_cast<std::int32_t>(systems[k]), kind, counts[k]});
  }
  return requests;
}

// This calculator's, as the manager would see it.
Load Engine::own_load(const System& system) const {
  const std::uint64_t processed = system.tally.at_start + system.tally.created;
  return {system.store->size(), balance::rescaled(system.tally.compute_s, processed, system.store->size()),
          system.speeds.of(calculator()), system.speeds.error(calculator())};
}

Proposal Engine::propose(const Request& request) {
  const System& s = *systems_[static_cast<std::size_t>(request.system)];
  std::vector<float> room;
  const std::span<const float> x = coordinates(s, room);
  const float low = s.domains.low(calculator());
  const float high = s.domains.high(calculator());
  charge(options_.costs.select * static_cast<double>(x.size()));
  Proposal proposal{request, {}, {}};
  switch (request.kind) {
    case Request::Kind::give_left: proposal.gift = balance::give_left(x, request.count, low, high); break;
    case Request::Kind::give_right: proposal.gift = balance::give_right(x, request.count, low, high); break;
    case Request::Kind::histogram: proposal.histogram = balance::histogram(x, static_cast<int>(request.count)); break;
  }
  return proposal;
}

void Engine::take_proposals(const Asked& asked) {
  bool whole = true;
  const AllSaid said = relay_.listen(Phase::proposals, asked.stamp);
  for (std::size_t from = 0; from < said.ranks.size(); ++from) {
    whole = whole && !said.ranks[from].failed;
    work("balance", [&] {
      for (particles::Reader in(said.ranks[from].bytes); !in.done();) {
        take_proposal(cast_.calculator_of(static_cast<int>(from)), read_proposal(in));
      }
    });
  }
  // A calculator that failed says so with its next report; until then cuts stay.
  if (whole) work("balance", [&] { move_cuts(asked.systems); });
}

void Engine::write_balance_rows() {
  if (log_ && !balance_rows_.empty()) {
    const std::string policy = options_.policy->name();
    work("log", [&] {
      for (auto& [key, row] : balance_rows_) {
        row.policy = policy;
        log_->add(row);
      }
      log_->write_balance();
    });
  }
  balance_rows_.clear();
}

void Engine::take_proposal(int calculator, const Proposal& proposal) {
  const auto system = static_cast<std::size_t>(proposal.request.system);
  if (proposal.request.kind == Request::Kind::histogram) {
    histograms_[system].resize(cast_.calculators.size());
    histograms_[system][static_cast<std::size_t>(calculator)] = proposal.histogram;
    return;
  }
  const bool right = proposal.request.kind == Request::Kind::give_right;
  const int sign = right ? 1 : -1;
  BalanceRow& row = row_of(system, right ? calculator : calculator - 1);
  row.ordered = sign * static_cast<std::int64_t>(proposal.request.count);
  row.given = sign * static_cast<std::int64_t>(proposal.gift.count);
  if (proposal.gift.count > 0) row.cut_after = proposal.gift.cut;
}

void Engine::move_cuts(const std::vector<std::size_t>& systems) {
  for (const std::size_t i : systems) {
    System& s = *systems_[i];
    std::vector<float> cuts = s.domains.cuts();
    if (!histograms_[i].empty()) {
      cuts = balance::prefix_cuts(histograms_[i], s.plan.costs, s.plan.shares, cuts);
      for (std::size_t c = 0; c < cuts.size(); ++c) row_of(i, static_cast<std::int32_t>(c)).cut_after = cuts[c];
    } else {
      for (auto row = balance_rows_.lower_bound({i, 0}); row != balance_rows_.end() && row->first.first == i; ++row) {
        cuts[static_cast<std::size_t>(row->first.second)] = row->second.cut_after;
      }
    }
    if (cuts != s.domains.cuts()) s.next_domains = domains::Domains(std::move(cuts));
  }
}

// For the log: where particles are at the frame's end.
void Engine::note_density() {
  if (calculator() < 0) return;
  std::vector<float> room;
  for (const auto& system : systems_) {
    Density density;
    density.particles = system->store->size();
    const std::vector<float> q = balance::quantiles(coordinates(*system, room), kQuantiles);
    if (q.empty()) density.particles = 0;
    std::copy(q.begin(), q.end(), density.quantiles);
    tail_.density.push_back(density);
  }
}

}  // namespace motes::frame
