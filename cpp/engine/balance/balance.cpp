#include "engine/balance/balance.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "balance/cells.h"
#include "balance/cuts.h"
#include "engine/balance/donate.h"
#include "engine/balance/neighbours.h"

namespace motes::engine {

using balance::Load;
using comm::Phase;

namespace {

// Returns the number of bins of a calculator's histogram, proportional to its particles: a bin holds less than a
// hundredth of a fair share, and the size of all histograms together depends only on the number of calculators.
std::uint64_t bins_for(const std::vector<Load>& loads, std::size_t calculator) {
  double all = 0;
  for (const Load& load : loads) all += static_cast<double>(load.particles);
  const double bins = 512 + 128 * static_cast<double>(loads.size());
  const double part = static_cast<double>(loads[calculator].particles) / std::max(all, 1.0);
  return std::max<std::uint64_t>(8, static_cast<std::uint64_t>(bins * part));
}

// Returns the loads of a system, summed with those of the systems that share its domains.
std::vector<Load> loads_of(const Script& script, const Manager& manager, std::size_t system) {
  std::vector<std::vector<Load>> loads;
  for (const std::size_t i : script.sharing(system)) loads.push_back(manager.systems[i].loads);
  return loads.size() == 1 ? loads[0] : balance::sum_of(loads);
}

// Returns the log's row of a cut that is being evaluated; creates it if there is none.
BalanceRow& row_of(const Rank& rank, const Script& script, Manager& manager, std::size_t system, std::int32_t cut) {
  const auto [found, is_new] = manager.rows.try_emplace({system, cut});
  BalanceRow& row = found->second;
  if (!is_new) return row;
  const auto left = static_cast<std::size_t>(cut);
  row.frame = rank.session.frame;
  row.system = script.systems[system]->definition.name;
  row.left_rank = rank.session.rank_of(cut);
  row.right_rank = rank.session.rank_of(cut + 1);
  const std::vector<Load> loads = loads_of(script, manager, system);
  row.left = loads[left];
  row.right = loads[left + 1];
  const domains::Cut at = script.systems[system]->domains.tree()[left];
  row.axis = at.axis;
  row.cut_before = row.cut_after = at.at;
  return row;
}

// Asks neighbours between which the plan moves particles to compare their loads; they decide how many to give.
void bring_together(const balance::Plan& plan, std::vector<Inquiry>& inquiries) {
  for (const balance::Order& order : plan.orders) {
    for (const auto& [one, other] : {std::pair{order.from, order.to}, std::pair{order.to, order.from}}) {
      std::vector<std::int32_t>& partners = inquiries[static_cast<std::size_t>(one)].partners;
      const auto place = std::lower_bound(partners.begin(), partners.end(), other);
      if (place == partners.end() || *place != other) partners.insert(place, other);
    }
  }
}

// Turns a plan into requests to donors.
void ask(const Rank& rank, const Script& script, Manager& manager, std::size_t system, const balance::Plan& plan,
         std::vector<Inquiry>& inquiries) {
  const auto index = static_cast<std::int32_t>(system);
  const bool alone = rank.settings.policy->decentralised();
  for (const std::int32_t cut : manager.account.log() != nullptr ? plan.evaluated : std::vector<std::int32_t>()) {
    BalanceRow& row = row_of(rank, script, manager, system, cut);
    if (alone) row.ordered = 0;
  }
  if (alone) return bring_together(plan, inquiries);
  // A plan with shares concerns all cuts, so all get rows with this frame's number, even if the policy names none.
  for (std::size_t cut = 0; !plan.shares.empty() && cut < script.systems[system]->domains.cuts().size(); ++cut) {
    row_of(rank, script, manager, system, static_cast<std::int32_t>(cut));
  }
  for (const balance::Order& order : plan.orders) {
    const bool right = order.to > order.from;
    const auto kind = right ? Request::Kind::give_right : Request::Kind::give_left;
    inquiries[static_cast<std::size_t>(order.from)].requests.push_back({index, kind, order.count});
    const auto count = static_cast<std::int64_t>(order.count);
    row_of(rank, script, manager, system, std::min(order.from, order.to)).ordered = right ? count : -count;
  }
  const bool bricks = script.systems[system]->definition.axes.bricks();
  const std::vector<Load> loads = loads_of(script, manager, system);
  for (std::size_t c = 0; !plan.shares.empty() && c < inquiries.size(); ++c) {
    const auto kind = bricks ? Request::Kind::cells : Request::Kind::histogram;
    inquiries[c].requests.push_back({index, kind, bins_for(loads, c)});
  }
  manager.systems[system].plan = plan;
}

void take_proposal(const Rank& rank, const Script& script, Manager& manager, int calculator, const Proposal& proposal) {
  const auto system = static_cast<std::size_t>(proposal.request.system);
  if (proposal.request.kind == Request::Kind::histogram) {
    std::vector<balance::Histogram>& histograms = manager.systems[system].histograms;
    histograms.resize(rank.session.calculators());
    histograms[static_cast<std::size_t>(calculator)] = proposal.histogram;
    return;
  }
  if (proposal.request.kind == Request::Kind::cells) {
    std::vector<std::vector<balance::Cell>>& cells = manager.systems[system].cells;
    cells.resize(rank.session.calculators());
    cells[static_cast<std::size_t>(calculator)] = proposal.cells;
    return;
  }
  const bool right = proposal.request.kind == Request::Kind::give_right;
  const int sign = right ? 1 : -1;
  BalanceRow& row = row_of(rank, script, manager, system, right ? calculator : calculator - 1);
  row.ordered = sign * static_cast<std::int64_t>(proposal.request.count);
  row.given = sign * static_cast<std::int64_t>(proposal.gift.count);
  if (proposal.gift.count > 0) row.cut_after = proposal.gift.cut;
}

void move_cuts(const Rank& rank, const Script& script, Manager& manager, const std::vector<std::size_t>& systems) {
  for (const std::size_t i : systems) {
    Balancing& balancing = manager.systems[i];
    const domains::Domains& before = script.systems[i]->domains;
    domains::Domains after = before;
    if (!balancing.cells.empty()) {
      after = balance::tree_cuts(balancing.cells, balancing.plan.costs, balancing.plan.shares, before);
    } else if (!balancing.histograms.empty()) {
      after = before.with(
          balance::prefix_cuts(balancing.histograms, balancing.plan.costs, balancing.plan.shares, before.cuts()));
    } else {
      std::vector<float> cuts = before.cuts();
      for (auto row = manager.rows.lower_bound({i, 0}); row != manager.rows.end() && row->first.first == i; ++row) {
        cuts[static_cast<std::size_t>(row->first.second)] = row->second.cut_after;
      }
      if (before.axis() >= 0) after = before.with(std::move(cuts));
    }
    for (std::size_t c = 0; !balancing.plan.shares.empty() && c < after.cuts().size(); ++c) {
      row_of(rank, script, manager, i, static_cast<std::int32_t>(c)).cut_after = after.cuts()[c];
    }
    if (after != before) balancing.next = std::move(after);
  }
}

void take_proposals(Rank& rank, const Script& script, Manager& manager, const PendingAnswers& pending) {
  bool whole = true;
  const Answers answers = rank.session.relay().listen(Phase::proposals, pending.stamp);
  for (std::size_t from = 0; from < answers.ranks.size(); ++from) {
    whole = whole && !answers.ranks[from].failed;
    rank.session.work("balance", [&] {
      for (base::Reader in(answers.ranks[from].bytes); !in.done();) {
        const int calculator = rank.session.cast().calculator_of(static_cast<int>(from));
        take_proposal(rank, script, manager, calculator, read_proposal(in));
      }
    });
  }
  // A failed calculator reports its failure in the next frame; until then cuts stay.
  if (whole) rank.session.work("balance", [&] { move_cuts(rank, script, manager, pending.systems); });
}

// Lets the policy plan from the round's loads, and turns the plans into requests to calculators.
void make_plan(const Rank& rank, const Script& script, Manager& manager, const Round& round,
               std::vector<Inquiry>& inquiries) {
  const balance::Policy& policy = *rank.settings.policy;
  const std::vector<std::size_t> systems = systems_to_balance(rank, script, round);
  balance::Plan whole;
  std::vector<Load> sum;
  if (policy.over_all && !systems.empty()) {
    std::vector<std::vector<Load>> loads;
    for (const std::size_t i : systems) loads.push_back(loads_of(script, manager, i));
    sum = balance::sum_of(loads);
    const std::size_t first = systems.front();
    // Orders must be possible in all systems, so prefer the axes of a system whose domains do not lie in a row.
    const auto of_no_row = std::find_if(systems.begin(), systems.end(),
                                        [&](std::size_t i) { return !script.systems[i]->definition.axes.row(); });
    const domains::Axes axes = script.systems[of_no_row == systems.end() ? first : *of_no_row]->definition.axes;
    const balance::LoadTable table{rank.session.frame,
                                   manager.systems[first].evaluations++,
                                   "all",
                                   sum,
                                   script.systems[first]->domains.cuts(),
                                   axes};
    whole = balance::legal(policy.plan(table), table, policy.name());
  }
  for (const std::size_t i : systems) {
    Balancing& system = manager.systems[i];
    if (policy.over_all) {
      ask(rank, script, manager, i, balance::part_of(whole, loads_of(script, manager, i), sum), inquiries);
    } else {
      const recording::SystemDefinition& definition = script.systems[i]->definition;
      const balance::LoadTable table{rank.session.frame,
                                     system.evaluations++,
                                     definition.name,
                                     loads_of(script, manager, i),
                                     script.systems[i]->domains.cuts(),
                                     definition.axes};
      ask(rank, script, manager, i, balance::legal(policy.plan(table), table, policy.name()), inquiries);
    }
  }
}

void tell_plan(Rank& rank, const Round& round, const std::vector<Inquiry>& inquiries) {
  Planned planned;
  planned.failure = rank.session.failure();
  std::vector<RankMessage> parts(static_cast<std::size_t>(rank.session.size()));
  for (std::size_t c = 0; c < inquiries.size(); ++c) {
    planned.asks = planned.asks || !inquiries[c].empty();
    write(inquiries[c], parts[static_cast<std::size_t>(rank.session.rank_of(static_cast<int>(c)))].bytes);
  }
  base::Bytes common;
  write(planned, common);
  rank.session.relay().tell(Phase::plan, rank.session.stamp(round), common, parts, planned.failure.failed());
}

// Computes the proposals for this donor's requests, or for what it decides together with its partners.
void propose_all(Rank& rank, const Script& script, Calculator& calculator, const Round& round, const Inquiry& inquiry,
                 base::Bytes& proposals) {
  std::vector<Request> requests = inquiry.requests;
  if (!inquiry.partners.empty()) {
    const std::vector<std::size_t> systems = systems_to_balance(rank, script, round);
    requests = decide_with_neighbours(rank, script, calculator, round, systems, inquiry.partners);
  }
  rank.session.work("balance", [&] {
    for (const Request& request : requests) {
      write(propose(rank, script, calculator, request), proposals);
    }
  });
  if (rank.session.failed()) proposals.clear();
}

ManagerMessage hear_plan(Rank& rank, const Script& script, const Round& round) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::balance, "wait for plan", script.name_of(round));
  return rank.session.relay().hear(Phase::plan, rank.session.stamp(round));
}

// Receives the plan of a round and answers it. The manager reads the answers later, so no rank waits for them.
void answer(Rank& rank, const Script& script, Calculator& calculator, Manager& manager, const Round& round) {
  Session& session = rank.session;
  const ManagerMessage message = hear_plan(rank, script, round);
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::balance, "balance", script.name_of(round));
  base::Reader common(message.common);
  const Planned planned = read_planned(common);
  if (planned.failure.failed()) {
    Verdict verdict;
    verdict.failure = planned.failure;
    verdict.failed_rank = session.cast().manager;
    session.give_up(std::move(verdict));
  }
  if (!planned.asks) return;
  base::Bytes proposals;
  if (session.calculates()) {
    base::Reader own(message.own);
    propose_all(rank, script, calculator, round, read_inquiry(own), proposals);
  }
  session.relay().say(Phase::proposals, session.stamp(round), proposals.view(), session.failed());
  session.relay().hand_up(Phase::proposals, session.stamp(round));
  if (session.manages()) manager.pending.push_back({session.stamp(round), systems_to_balance(rank, script, round)});
}

void write_rows(Rank& rank, Manager& manager) {
  if (Log* log = manager.account.log(); log != nullptr && !manager.rows.empty()) {
    const std::string policy = rank.settings.policy->name();
    rank.session.work("log", [&] {
      for (auto& [key, row] : manager.rows) {
        row.policy = policy;
        log->add(row);
      }
      log->write_balance();
    });
  }
  manager.rows.clear();
}

// Warns about a slow balancer, but only about scripted ones, which their authors can make faster.
void watch_balancer(const Rank& rank, const Script& script, Manager& manager, double decided_s) {
  const balance::Policy& policy = *rank.settings.policy;
  const std::optional<FrameRow>& last = manager.account.last_row();
  if (!policy.scripted() || !last) return;
  for (Alarm& alarm : manager.alarms.look_at_balancer(policy.name(), decided_s, last->times.frame)) {
    say(std::move(alarm), script.record.frame, manager);
  }
}

}  // namespace

bool balances(const Rank& rank, const Script& script) {
  const balance::Policy* policy = rank.settings.policy.get();
  return script.in_frame() && policy != nullptr && policy->moves() && rank.session.calculators() > 1;
}

std::vector<std::size_t> systems_to_balance(const Rank& rank, const Script& script, const Round& round) {
  std::vector<std::size_t> systems;
  const bool all = rank.settings.policy->over_all || rank.settings.policy->unmanaged();
  if (all && round.last < script.systems.size()) return systems;
  for (std::size_t i = all ? 0 : round.first; i < round.last; ++i) {
    const System& system = *script.systems[i];
    if (!system.waits_for_fit && system.definition.domains_of < 0) systems.push_back(i);
  }
  return systems;
}

bool plans(const Rank& rank, const Script& script, const Round& round) {
  return balances(rank, script) && !rank.settings.policy->unmanaged() &&
         !systems_to_balance(rank, script, round).empty();
}

void note_loads(const Rank& rank, const Script& script, Manager& manager, const Round& round, const Loads& loads) {
  const roles::Tree& tree = rank.session.relay().tree();
  const std::size_t calculators = rank.session.calculators();
  const bool alone = rank.settings.policy->unmanaged();  // then use the loads that neighbours compared
  for (std::size_t i = round.first; i < round.last; ++i) {
    std::vector<Load>& of_all = manager.systems[i].loads;
    of_all.resize(calculators);
    for (std::size_t c = 0; c < calculators; ++c) {
      const CalculatorLoad& from = loads.of(tree, static_cast<int>(c), i - round.first);
      const std::uint64_t alive = std::uint64_t{from.stayed} + from.sent;
      const std::uint64_t particles =
          alone ? expected_of(script, i, static_cast<int>(c), alive) : std::uint64_t{from.stayed} + from.received;
      of_all[c] = {particles, 0, from.speed, from.error};
    }
  }
  if (round.last == script.systems.size() && !alone) {
    note_children(script, manager, [&](std::size_t into, int calculator, std::uint64_t count) {
      if (into >= round.first) manager.systems[into].loads[static_cast<std::size_t>(calculator)].particles += count;
    });
  }
  for (std::size_t i = round.first; i < round.last; ++i) {
    for (std::size_t c = 0; c < calculators; ++c) {
      const CalculatorLoad& from = loads.of(tree, static_cast<int>(c), i - round.first);
      Load& load = manager.systems[i].loads[c];
      load.seconds = balance::rescaled(from.compute_s, std::uint64_t{from.at_start} + from.created, load.particles);
    }
  }
}

void note_decisions(const Rank& rank, const Script& script, Manager& manager, const std::vector<Decision>& decisions) {
  if (manager.account.log() == nullptr) return;
  const auto cuts = static_cast<std::int32_t>(rank.session.calculators()) - 1;
  for (const std::size_t i : systems_to_balance(rank, script, script.rounds.back())) {
    for (std::int32_t cut = 0; cut < cuts; ++cut) row_of(rank, script, manager, i, cut).ordered = 0;
  }
  for (const Decision& decision : decisions) {
    const auto cut = static_cast<std::int32_t>(decision.cut.cut);
    BalanceRow& row = row_of(rank, script, manager, decision.cut.system, cut);
    row.ordered = decision.ordered;
    row.given = decision.cut.given;
    row.cut_after = decision.cut.at;
  }
}

void plan(Rank& rank, const Script& script, Manager& manager) {
  double decided_s = 0;
  for (const Round& round : script.rounds) {
    if (!plans(rank, script, round)) continue;
    const Stopwatch::Phase phase(rank.watch, &PhaseTimes::balance, "plan", script.name_of(round));
    std::vector<Inquiry> inquiries(rank.session.calculators());
    const double start = comm::wall_seconds();
    rank.session.work("balancer " + rank.settings.policy->name(),
                      [&] { make_plan(rank, script, manager, round, inquiries); });
    decided_s += comm::wall_seconds() - start;
    tell_plan(rank, round, inquiries);
  }
  if (decided_s > 0) watch_balancer(rank, script, manager, decided_s);
}

void balance(Rank& rank, const Script& script, Calculator& calculator, Manager& manager) {
  if (!balances(rank, script)) return;
  for (const Round& round : script.rounds) {
    if (plans(rank, script, round)) answer(rank, script, calculator, manager, round);
  }
}

void take_all_proposals(Rank& rank, const Script& script, Manager& manager) {
  if (manager.pending.empty() && manager.rows.empty()) return;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::balance, "new cuts");
  for (Balancing& system : manager.systems) {
    system.histograms.clear();
    system.cells.clear();
  }
  for (const PendingAnswers& pending : std::exchange(manager.pending, {}))
    take_proposals(rank, script, manager, pending);
  write_rows(rank, manager);
}

}  // namespace motes::engine
