#include "engine/agree.h"

#include <algorithm>
#include <utility>

#include "comm/clock.h"
#include "engine/balance/balance.h"
#include "engine/balance/neighbours.h"
#include "engine/births/share.h"
#include "engine/births/spawn.h"
#include "engine/render/render_load.h"
#include "engine/session/reports.h"
#include "engine/state/walls.h"

namespace motes::engine {

using comm::Phase;

namespace {

std::uint32_t counted(std::uint64_t particles) { return static_cast<std::uint32_t>(particles); }

CalculatorLoad own_load(const Population& here) {
  CalculatorLoad load;
  load.at_start = counted(here.tally.at_start);
  load.created = counted(here.tally.created);
  load.killed = counted(here.tally.killed);
  load.stayed = counted(here.seen());
  load.sent = counted(here.tally.sent);
  load.compute_s = here.tally.compute_s;
  load.speed = here.speeds.of(0);
  load.error = here.speeds.error(0);
  return load;
}

// Returns the factor by which births and pictures slowed this rank in the last frame, relative to actions only. It is 1
// unless ranks that calculate also manage or draw. The image generator's wait for records counts too, since it cannot
// act meanwhile.
double slowed_by_other_work(const Rank& rank) {
  const roles::Cast& cast = rank.session.cast();
  if (cast.calculator_of(cast.manager) < 0 && cast.calculator_of(cast.image_generator) < 0) return 1;
  const comm::Spent& spent = rank.watch.spent();
  const auto of = [&](comm::Activity activity) { return spent.activities[static_cast<std::size_t>(activity)]; };
  const double act_s = of(comm::Activity::act);
  if (act_s < rank.settings.policy->speeds.min_seconds) return 1;
  double other_s = of(comm::Activity::births) + of(comm::Activity::picture);
  for (const comm::Waited& wait : spent.waits) {
    if (wait.phase == static_cast<std::int32_t>(Phase::records)) other_s += wait.seconds;
  }
  return 1 + other_s / act_s;
}

void report_system(const Rank& rank, const Script& script, Population& here, std::uint32_t number, Round& round) {
  const Strain strain{here.interaction.most_in_a_cell, here.interaction.overlap_99, here.interaction.substeps};
  SystemReport system{here.seen() + here.tally.sent, strain, here.digest, here.oldest, {}};
  for (const Sent& sent : here.sent) {
    round.own.flows.push_back({counted(static_cast<std::uint64_t>(rank.session.calculator())),
                               static_cast<std::uint32_t>(sent.domain), number, counted(sent.count)});
  }
  if (script.in_frame()) system.events = here.events;
  for (const auto& [place, sum] : here.walls) {
    if (script.in_frame())
      round.own.walls.push_back({static_cast<std::uint32_t>(round.first) + number, place.first, place.second, sum});
  }
  if (balances(rank, script)) {
    const std::uint64_t processed = here.tally.at_start + here.tally.created;
    here.speeds.add(0, processed, here.tally.compute_s * slowed_by_other_work(rank), here.tally.created);
    const std::uint64_t expected =
        expected_of(script, round.first + number, rank.session.calculator(), system.particles);
    here.expected = {expected, balance::rescaled(here.tally.compute_s, processed, expected), here.speeds.of(0),
                     here.speeds.error(0)};
  }
  round.own_loads.push_back(own_load(here));
  round.own.systems.push_back(std::move(system));
}

// Fills in the report of each system on this calculator.
void report_systems(const Rank& rank, const Script& script, const Calculator& calculator, Round& round) {
  round.own = {};
  round.own_loads.clear();
  for (std::size_t i = round.first; rank.session.calculates() && i < round.last; ++i) {
    report_system(rank, script, *calculator.populations[i], static_cast<std::uint32_t>(i - round.first), round);
  }
}

// Adds viewers' orders to the report, once per conversation: in its last round, the latest one that can still reach all
// ranks.
void report_orders(Rank& rank, const Script& script, Round& round) {
  const bool last = round.last == script.systems.size();
  if (!script.steered() || !last || !rank.session.draws() || !rank.settings.orders) return;
  rank.session.work("viewers", [&] { round.own.orders = rank.settings.orders(); });
}

// Fills in this rank's part of the report: its failure or differing list, a signal, its tails.
void report_rank(const Rank& rank, const Script& script, Calculator& calculator, Round& round) {
  const Failure& failure = rank.session.failure();
  if (failure.kind == Failure::Kind::mismatch) {
    round.own.dissents.push_back({rank.session.rank(), {}});
    round.own.dissents.back().record.put_raw(script.bytes.data(), script.bytes.size());
  } else if (failure.failed()) {
    round.own.failure = failure;
    round.own.failed_rank = rank.session.rank();
  }
  if (script.steered() && rank.settings.stop_signal) {
    round.own.stop = static_cast<std::uint8_t>(rank.settings.stop_signal());
  }
  round.own.unsaved_from = rank.session.unsaved_from;
  round.own.tail = std::exchange(calculator.tail, {});
  round.own_tails = std::exchange(calculator.tails, {});
  round.own_spent = rank.watch.spent();
  round.tells_tails = round.own.tail.valid && !rank.settings.log.directory.empty();
}

// Returns a verdict that names the ranks outside the largest group with the same list; in a tie, the group of the
// lowest rank wins.
Verdict mismatch(const Script& script, int ranks, const std::vector<Dissent>& dissents) {
  std::vector<std::span<const std::byte>> lists(static_cast<std::size_t>(ranks), script.bytes.view());
  for (const Dissent& dissent : dissents) lists[static_cast<std::size_t>(dissent.rank)] = dissent.record.view();
  std::size_t most = 0;
  std::size_t model = 0;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    const auto same = std::count_if(lists.begin(), lists.end(), [&](auto other) {
      return std::equal(other.begin(), other.end(), lists[i].begin(), lists[i].end());
    });
    if (static_cast<std::size_t>(same) > most) {
      most = static_cast<std::size_t>(same);
      model = i;
    }
  }
  Verdict verdict;
  std::string difference;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    if (std::equal(lists[i].begin(), lists[i].end(), lists[model].begin(), lists[model].end())) continue;
    verdict.ranks.push_back(static_cast<std::int32_t>(i));
    if (!difference.empty()) continue;
    base::Reader ours(lists[i]);
    base::Reader theirs(lists[model]);
    difference = recording::first_difference(recording::read(ours), recording::read(theirs));
  }
  verdict.failed_rank = verdict.ranks.front();
  verdict.failure = {Failure::Kind::mismatch, recording::name(script.record.verb),
                     difference + " (here: rank " + std::to_string(verdict.failed_rank) + ", there: rank " +
                         std::to_string(model) + ")"};
  return verdict;
}

// Returns a verdict on mismatches and failures. Mismatches take precedence, since failures of a rank whose script
// differs mean little.
Verdict compare(const Script& script, int ranks, const Report& report) {
  if (!report.dissents.empty()) return mismatch(script, ranks, report.dissents);
  Verdict verdict;
  verdict.failure = report.failure;
  verdict.failed_rank = report.failed_rank;
  verdict.stop = report.stop;
  verdict.unsaved_from = report.unsaved_from;
  verdict.orders = report.orders;
  return verdict;
}

void sum_up(const Script& script, const Round& round, const Report& report, Verdict& verdict) {
  for (const Decision& decision : report.decisions) {
    if (decision.cut.given != 0) verdict.cuts.push_back(decision.cut);
  }
  verdict.walls = report.walls;
  verdict.alive.assign(script.systems.size(), 0);
  verdict.digests.assign(script.systems.size(), {});
  verdict.oldest.assign(script.systems.size(), UINT64_MAX);
  for (std::size_t i = round.first; i < round.last; ++i) {
    const SystemReport& system = report.systems.at(i - round.first);
    verdict.alive[i] = system.particles;
    verdict.digests[i] = system.digest;
    verdict.oldest[i] = system.oldest;
  }
}

// Returns the entries of calculators at places first .. end - 1 of the tree. `all` must be in the order of the tree.
template <class T, class Calculator>
std::vector<T> within(const std::vector<T>& all, const roles::Tree& tree, int first, int end, Calculator calculator) {
  const auto before = [&](const T& one, int place) { return tree.place_of(static_cast<int>(one.*calculator)) < place; };
  return {std::lower_bound(all.begin(), all.end(), first, before),
          std::lower_bound(all.begin(), all.end(), end, before)};
}

// Keeps this rank's part of the verdict and sends the ranks below theirs. Adds the flows within this subtree, which no
// rank above knows.
void pass_on(Rank& rank, Round& round, Judgement judgement, const std::vector<Flow>& staying) {
  Relay& relay = rank.session.relay();
  const roles::Tree& tree = relay.tree();
  const bool failed = judgement.verdict.failure.failed();
  for (const Flow& flow : staying) {
    if (!failed) judgement.transfers.push_back({flow.to, flow.from});
  }
  const auto key = [&](const Transfer& t) { return std::pair(tree.place_of(static_cast<int>(t.to)), t.from); };
  std::sort(judgement.transfers.begin(), judgement.transfers.end(),
            [&](const Transfer& a, const Transfer& b) { return key(a) < key(b); });
  judgement.transfers.erase(std::unique(judgement.transfers.begin(), judgement.transfers.end()),
                            judgement.transfers.end());
  const auto among = [&](int first, int end) {
    return Judgement{judgement.verdict, within(judgement.transfers, tree, first, end, &Transfer::to),
                     within(judgement.parents, tree, first, end, &OwnedParent::owner)};
  };
  for (const roles::Tree::Range& child : tree.children()) {
    comm::Message message;
    write(among(child.first, child.end), message.bytes());
    relay.pass_down(child, Phase::verdict, rank.session.stamp(round), std::move(message), failed);
  }
  const Judgement own = among(tree.own().first, tree.own().first + 1);
  round.orders = {};
  for (const Transfer& transfer : own.transfers) {
    round.orders.senders.push_back(rank.session.rank_of(static_cast<int>(transfer.from)));
  }
  for (const OwnedParent& owned : own.parents) round.orders.parents.push_back(owned.parent);
  round.verdict = std::move(judgement.verdict);
}

// Warns about systems that pictures do not show, after each picture and at the end of the run.
void watch_pictures(const Script& script, const Tail& tail, Manager& manager) {
  const std::uint64_t frame = tail.valid ? tail.frame : script.record.frame;
  const auto look = [&](std::size_t system, Sighted sighted, bool last) {
    const std::string& name = script.systems[system]->definition.name;
    for (Alarm& alarm : manager.alarms.look_at_picture(system, name, sighted, last)) {
      say(std::move(alarm), frame, manager);
    }
  };
  const std::vector<Sighted>& sighted = tail.drawings.sighted;
  for (std::size_t i = 0; i < sighted.size() && i < script.systems.size(); ++i) look(i, sighted[i], false);
  if (script.record.verb != recording::Verb::finish) return;
  for (std::size_t i = 0; i < script.systems.size(); ++i) look(i, Sighted::unknown, true);
}

// Warns about problems in the interactions of a round's systems.
void watch(const Script& script, const Round& round, const std::vector<Strain>& strains, const Settings& settings,
           Manager& manager) {
  for (std::size_t i = round.first; i < round.last && i - round.first < strains.size(); ++i) {
    const System& system = *script.systems[i];
    for (Alarm& alarm :
         manager.alarms.look(i, system.definition.name, strains[i - round.first], settings.substeps, settings.dt)) {
      say(std::move(alarm), script.record.frame, manager);
    }
  }
}

}  // namespace

void report(Rank& rank, const Script& script, Calculator& calculator, Round& round, const Newborn& newborn) {
  report_systems(rank, script, calculator, round);
  if (newborn.compare && rank.session.calculates()) round.own.decisions = decide_alone(rank, script, calculator, round);
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::report, "report", script.name_of(round));
  round.reported_s = comm::wall_seconds();
  report_orders(rank, script, round);
  report_rank(rank, script, calculator, round);
  send_report(rank, round);
}

void judge(Rank& rank, const Script& script, Manager& manager, Round& round) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::report, "judge", script.name_of(round));
  take_tails(rank, manager);  // while the others act
  {
    const comm::ActivityScope turn(rank.watch.ledger(), comm::Activity::log);
    manager.account.write_rows();
  }
  Gathered gathered = gather_reports(rank, round);
  Judgement judgement;
  judgement.verdict = compare(script, rank.session.size(), gathered.report);
  if (!judgement.verdict.failure.failed()) {
    sum_up(script, round, gathered.report, judgement.verdict);
    collect_parents(rank, script, manager, round, gathered.report.systems, judgement);
  }
  pass_on(rank, round, std::move(judgement), gathered.staying);
  if (round.verdict.failure.failed()) return;
  // The rest happens after the verdict, when no rank waits for the manager.
  std::vector<Strain> strains;
  for (const SystemReport& system : gathered.report.systems) strains.push_back(system.strain);
  manager.judged.push_back({std::move(gathered.report.tail), loads_of(rank, round, gathered), std::move(strains)});
  if (balances(rank, script)) note_loads(rank, script, manager, round, manager.judged.back().loads);
  if (compare_alone(rank, script, round)) note_decisions(rank, script, manager, gathered.report.decisions);
}

void hear_verdict(Rank& rank, Script& script, Round& round) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::report, "wait for verdict", script.name_of(round));
  if (!rank.session.manages()) {
    const std::vector<Flow> staying = pass_reports(rank, round);
    const comm::Message message = rank.session.relay().from_above(Phase::verdict, rank.session.stamp(round));
    base::Reader in = message.reader();
    pass_on(rank, round, read_judgement(in), staying);
  }
  if (round.verdict.failure.failed()) rank.session.give_up(std::move(round.verdict));
  rank.session.stop = std::max<int>(rank.session.stop, round.verdict.stop);
  rank.session.all_unsaved_from = round.verdict.unsaved_from;
  rank.session.orders += round.verdict.orders;
  script.new_cuts.insert(script.new_cuts.end(), round.verdict.cuts.begin(), round.verdict.cuts.end());
  note_walls(script, round);
  for (std::size_t i = round.first; i < round.last; ++i) {
    System& system = *script.systems[i];
    system.counts.alive = round.verdict.alive[i];
    system.digest = round.verdict.digests[i];
    // Conversations other than frames do not look for the lowest live id, and births may be pending.
    if (system.asks_oldest && script.in_frame()) system.history.forget_before(round.verdict.oldest[i]);
  }
}

void keep_account(Rank& rank, const Script& script, Manager& manager) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::report, "judge");
  const roles::Tree& tree = rank.session.relay().tree();
  for (std::size_t r = 0; r < manager.judged.size(); ++r) {
    const Round& round = script.rounds[r];
    const Judged& judged = manager.judged[r];
    if (r == 0) {
      manager.account.note_tail(judged.tail);
      watch_pictures(script, judged.tail, manager);
    }
    if (round.tells_tails) manager.tails = AwaitedTails{rank.session.stamp(round), round.own_tails, round.own_spent};
    note_pictures(rank, script, round, judged, manager.picture);
    if (!script.in_frame()) continue;
    manager.account.note_round(script, round, judged, rank.session.cast(), tree);
    if (const std::optional<Births> by = births_by(rank, script)) manager.account.note_births(*by);
    watch(script, round, judged.strains, rank.settings, manager);
    if (round.last < script.systems.size()) continue;
    note_children(script, manager, [&](std::size_t into, int calculator, std::uint64_t count) {
      manager.account.note_children(into, calculator, count);
    });
    manager.account.close_row(script, rank.session.cast(), rank.settings.log.digest);
  }
  manager.judged.clear();
}

void take_tails(Rank& rank, Manager& manager) {
  std::optional<AwaitedTails> tails = std::exchange(manager.tails, std::nullopt);
  if (!tails) return;
  AllTails all = gather_tails(rank, tails->stamp, std::move(tails->own), std::move(tails->own_spent));
  manager.account.note_tails(all.calculators, rank.session.relay().tree());
  manager.account.note_times(std::move(all.times));
}

}  // namespace motes::engine
