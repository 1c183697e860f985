#include "frame/agree.h"

#include <algorithm>
#include <utility>

#include "comm/clock.h"
#include "frame/balance.h"
#include "frame/render_load.h"
#include "frame/spawn.h"

namespace motes::frame {

using comm::Phase;

namespace {

Report own_report(const Rank& rank, const Script& script, Calculator& calculator, const Round& round) {
  Report report;
  report.failure = rank.talk.failure();
  if (report.failure.kind == Failure::Kind::mismatch) {
    report.record.put_raw(script.bytes.data(), script.bytes.size());
  }
  for (std::size_t i = round.first; rank.talk.calculates() && i < round.last; ++i) {
    const Population& here = *calculator.populations[i];
    SystemReport row;
    row.at_start = here.tally.at_start;
    row.created = here.tally.created;
    row.killed = here.tally.killed;
    row.kept = here.seen();
    row.compute_s = here.tally.compute_s;
    row.sent = here.sent;
    row.digest = here.digest;
    row.oldest = here.oldest;
    if (script.in_frame()) row.events = here.events;
    report.systems.push_back(std::move(row));
  }
  report.tail = std::exchange(calculator.tail, {});
  return report;
}

// The ranks outside the largest group that recorded the same list; the lowest rank's group wins a tie.
Verdict mismatch(const Script& script, const std::vector<Report>& reports) {
  std::vector<std::span<const std::byte>> lists;
  for (const Report& report : reports) {
    lists.push_back(report.failure.kind == Failure::Kind::mismatch ? report.record.view() : script.bytes.view());
  }
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
    particles::Reader ours(lists[i]);
    particles::Reader theirs(lists[model]);
    difference = recording::first_difference(recording::read(ours), recording::read(theirs));
  }
  verdict.failed_rank = verdict.ranks.front();
  verdict.failure = {Failure::Kind::mismatch, recording::name(script.record.verb),
                     difference + " (here: rank " + std::to_string(verdict.failed_rank) + ", there: rank " +
                         std::to_string(model) + ")"};
  return verdict;
}

// A rank whose script differs says nothing reliable about computing, so mismatches are told first.
Verdict compare(const Script& script, const std::vector<Report>& reports) {
  const auto differs = [](const Report& r) { return r.failure.kind == Failure::Kind::mismatch; };
  if (std::any_of(reports.begin(), reports.end(), differs)) return mismatch(script, reports);
  Verdict verdict;
  for (std::size_t rank = 0; rank < reports.size(); ++rank) {
    if (!reports[rank].failure.failed()) continue;
    verdict.failure = reports[rank].failure;
    verdict.failed_rank = static_cast<std::int32_t>(rank);
    break;
  }
  return verdict;
}

// Children in the account, once all rounds are judged.
void count_children(const Script& script, Manager& manager, const Round& last, const Verdict& verdict) {
  std::vector<std::uint64_t> alive;
  for (const auto& system : script.systems) alive.push_back(system->counts.alive);
  for (std::size_t i = last.first; i < last.last; ++i) alive[i] = verdict.alive[i];
  note_children(script, manager, alive);
}

// Counts and fingerprints over all calculators, and for each calculator the ranks that will send it particles.
void sum_up(const Rank& rank, const Script& script, const Round& round, const std::vector<Report>& reports,
            Verdict& verdict, std::vector<Orders>& orders) {
  verdict.alive.assign(script.systems.size(), 0);
  verdict.digests.assign(script.systems.size(), {});
  verdict.oldest.assign(script.systems.size(), UINT64_MAX);
  for (const int from : rank.talk.cast().calculators) {
    const std::vector<SystemReport>& systems = reports[static_cast<std::size_t>(from)].systems;
    for (std::size_t i = round.first; i < round.last; ++i) {
      const SystemReport& system = systems[i - round.first];
      verdict.alive[i] += system.kept;
      verdict.digests[i] += system.digest;
      verdict.oldest[i] = std::min(verdict.oldest[i], system.oldest);
      for (const Sent& sent : system.sent) {
        verdict.alive[i] += sent.count;
        std::vector<std::int32_t>& sources = orders[static_cast<std::size_t>(sent.domain)].sources;
        if (sources.empty() || sources.back() != from) sources.push_back(from);
      }
    }
  }
}

std::vector<Report>& hear_reports(Rank& rank, Manager& manager, const Round& round) {
  const AllSaid said = rank.talk.relay().listen(Phase::report, rank.talk.stamp(round));
  double systems = 0;
  manager.reports.resize(said.ranks.size());
  for (std::size_t from = 0; from < manager.reports.size(); ++from) {
    particles::Reader in(said.ranks[from].bytes);
    read(in, manager.reports[from]);
    systems += static_cast<double>(manager.reports[from].systems.size());
  }
  rank.machine.charge_once(rank.machine.costs().report * systems);
  return manager.reports;
}

// What all ranks did well: counts, children, the account, the loads that the plan will follow from.
void settle_well(const Rank& rank, const Script& script, Manager& manager, const Round& round, Verdict& verdict) {
  if (round.first == 0) manager.account.note_tails(manager.reports, rank.talk.cast());
  note_pictures(rank, script, round, manager.reports, manager.picture);
  sum_up(rank, script, round, manager.reports, verdict, manager.orders);
  collect_parents(rank, script, manager, round, manager.reports, verdict, manager.orders);
  if (script.in_frame()) {
    manager.account.note_round(script, round, manager.reports, verdict, rank.talk.cast());
    if (round.last == script.systems.size()) count_children(script, manager, round, verdict);
    if (balances(rank, script)) note_loads(rank, script, manager, round);
  }
  if (script.in_frame() && round.last == script.systems.size()) {
    manager.account.close_row(rank.talk.cast(), rank.settings.log.digest);
  }
}

}  // namespace

void report(Rank& rank, const Script& script, Calculator& calculator, Round& round) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::report, "report", script.name_of(round));
  round.reported_s = comm::wall_seconds();
  particles::Bytes bytes;
  write(own_report(rank, script, calculator, round), bytes);
  rank.talk.relay().say(Phase::report, rank.talk.stamp(round), bytes.view(), rank.talk.failed());
}

void judge(Rank& rank, const Script& script, Manager& manager, const Round& round) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::report, "judge", script.name_of(round));
  manager.account.write_rows();  // while the others act
  Verdict verdict = compare(script, hear_reports(rank, manager, round));
  manager.orders.resize(rank.talk.calculators());
  for (Orders& of_one : manager.orders) of_one.clear();
  if (!verdict.failure.failed()) settle_well(rank, script, manager, round, verdict);
  manager.parts.resize(static_cast<std::size_t>(rank.talk.size()));
  for (std::size_t c = 0; c < manager.orders.size(); ++c) {
    const Orders& orders = manager.orders[c];
    particles::Bytes& part = manager.parts[static_cast<std::size_t>(rank.talk.rank_of(static_cast<int>(c)))].bytes;
    part.clear();
    write(orders, part);
  }
  particles::Bytes common;
  write(verdict, common);
  rank.talk.relay().tell(Phase::verdict, rank.talk.stamp(round), common, manager.parts, verdict.failure.failed());
}

void hear_verdict(Rank& rank, Script& script, Round& round) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::report, "wait for verdict", script.name_of(round));
  rank.talk.relay().hand_up(Phase::report, rank.talk.stamp(round));
  const Heard answer = rank.talk.relay().hear(Phase::verdict, rank.talk.stamp(round));
  particles::Reader common(answer.common);
  particles::Reader own(answer.own);
  round.verdict = read_verdict(common);
  round.orders = own.done() ? Orders{} : read_orders(own);
  if (round.verdict.failure.failed()) rank.talk.give_up(std::move(round.verdict));
  for (std::size_t i = round.first; i < round.last; ++i) {
    System& system = *script.systems[i];
    system.counts.alive = round.verdict.alive[i];
    system.digest = round.verdict.digests[i];
    if (system.asks_oldest) system.history.forget_before(round.verdict.oldest[i]);
  }
}

}  // namespace motes::frame
