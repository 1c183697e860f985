// agree: all ranks report to the manager, which answers all: loads and counts, who sends particles to whom, and
// whether a rank failed or recorded another list. Whatever the answer is, all ranks do the same thing next.
#include <algorithm>
#include <utility>

#include "comm/clock.h"
#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using comm::Phase;

void Engine::report(Round& round) {
  const Timed timed(*this, times_.report, "report", name_of(round));
  round.reported_s = comm::wall_seconds();
  particles::Bytes words;
  write(own_report(round), words);
  relay_.say(Phase::report, stamp(round), words.view(), failure_.failed());
}

Report Engine::own_report(const Round& round) {
  Report report;
  report.failure = failure_;
  if (failure_.kind == Failure::Kind::mismatch) {
    report.record.put_raw(record_bytes_.data(), record_bytes_.size());
  }
  for (std::size_t i = round.first; calculator() >= 0 && i < round.last; ++i) {
    const System& s = *systems_[i];
    SystemReport row;
    row.at_start = s.tally.at_start;
    row.created = s.tally.created;
    row.killed = s.tally.killed;
    row.kept = s.store->size();
    row.compute_s = s.tally.compute_s;
    row.sent = s.sent;
    row.digest = digests_[i];
    if (in_frame()) row.events = s.events;
    report.systems.push_back(std::move(row));
  }
  report.tail = std::exchange(tail_, {});
  return report;
}

void Engine::judge(Round& round) {
  const Timed timed(*this, times_.report, "judge", name_of(round));
  write_rows();  // while the others act
  std::vector<Report>& reports = reports_;
  const AllSaid said = relay_.listen(Phase::report, stamp(round));
  double systems = 0;
  reports.resize(said.ranks.size());
  for (std::size_t rank = 0; rank < reports.size(); ++rank) {
    particles::Reader in(said.ranks[rank].bytes);
    read(in, reports[rank]);
    systems += static_cast<double>(reports[rank].systems.size());
  }
  charge(options_.costs.report / options_.costs.scale * systems);  // as long for few particles as for many
  Verdict verdict = compare(reports);
  std::vector<Orders>& orders = orders_;
  orders.resize(cast_.calculators.size());
  for (Orders& of_one : orders) of_one.clear();
  if (!verdict.failure.failed()) {
    if (round.first == 0) note_tails(reports);
    sum_up(round, reports, verdict, orders);
    collect_offspring(round, reports, verdict);
    note_round(round, reports, verdict);
    if (balances() && !failure_.failed()) {
      work("balancer " + options_.policy->name(), [&] { plan(round, orders); });
      if (failure_.failed()) {
        verdict.failure = failure_;
        verdict.failed_rank = rank();
      }
    }
  }
  parts_.resize(static_cast<std::size_t>(comm_->size()));
  for (std::size_t c = 0; c < orders.size(); ++c) {
    verdict.asks = verdict.asks || !orders[c].requests.empty() || !orders[c].partners.empty();
    particles::Bytes& words = parts_[static_cast<std::size_t>(cast_.calculators[c])].bytes;
    words.clear();
    write(orders[c], words);
  }
  particles::Bytes common;
  write(verdict, common);
  relay_.tell(Phase::verdict, stamp(round), common, parts_, verdict.failure.failed());
}

// Counts and fingerprints over all calculators, and for each calculator the ranks that will send it particles.
void Engine::sum_up(const Round& round, const std::vector<Report>& reports, Verdict& verdict,
                    std::vector<Orders>& orders) const {
  verdict.alive.assign(systems_.size(), 0);
  verdict.digests.assign(systems_.size(), {});
  for (const int rank : cast_.calculators) {
    const std::vector<SystemReport>& systems = reports[static_cast<std::size_t>(rank)].systems;
    for (std::size_t i = round.first; i < round.last; ++i) {
      const SystemReport& system = systems[i - round.first];
      verdict.alive[i] += system.kept;
      verdict.digests[i] += system.digest;
      for (const Sent& sent : system.sent) {
        verdict.alive[i] += sent.count;
        std::vector<std::int32_t>& from = orders[static_cast<std::size_t>(sent.domain)].sources;
        if (from.empty() || from.back() != rank) from.push_back(rank);
      }
    }
  }
}

// Children are numbered in the order of systems, rules and the parents' ids: no rank can show in it.
void Engine::collect_offspring(const Round& round, std::vector<Report>& reports, Verdict& verdict) {
  verdict.spawned.assign(systems_.size(), 0);
  for (std::size_t i = round.first; in_frame() && i < round.last; ++i) {
    const std::vector<const recording::Spawn*> rules = systems_[i]->rules();
    for (std::size_t r = 0; r < rules.size(); ++r) {
      recording::Offspring offspring{*rules[r], {}};
      for (const int rank : cast_.calculators) {
        const auto& events = reports[static_cast<std::size_t>(rank)].systems[i - round.first].events;
        if (r < events.size()) offspring.events.insert(offspring.events.end(), events[r].begin(), events[r].end());
      }
      if (offspring.events.empty()) continue;
      std::sort(offspring.events.begin(), offspring.events.end(),
                [](const recording::Event& a, const recording::Event& b) { return a.id < b.id; });
      const auto into = static_cast<std::size_t>(offspring.rule.into);
      verdict.spawned[into] += offspring.events.size() * offspring.rule.count;
      systems_[into]->next_offspring.push_back(std::move(offspring));
    }
  }
}

// A rank whose script differs says nothing reliable about computing, so mismatches are told first.
Verdict Engine::compare(std::vector<Report>& reports) const {
  const auto differs = [](const Report& r) { return r.failure.kind == Failure::Kind::mismatch; };
  if (std::any_of(reports.begin(), reports.end(), differs)) return mismatch(reports);
  Verdict verdict;
  for (std::size_t rank = 0; rank < reports.size(); ++rank) {
    if (!reports[rank].failure.failed()) continue;
    verdict.failure = reports[rank].failure;
    verdict.failed_rank = static_cast<std::int32_t>(rank);
    break;
  }
  return verdict;
}

// The ranks outside the largest group that recorded the same list; the lowest rank's group wins a tie.
Verdict Engine::mismatch(std::vector<Report>& reports) const {
  std::vector<std::span<const std::byte>> lists;
  for (const Report& report : reports) {
    lists.push_back(report.failure.kind == Failure::Kind::mismatch ? report.record.view() : record_bytes_.view());
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
  verdict.failure = {Failure::Kind::mismatch, recording::name(record_.verb),
                     difference + " (here: rank " + std::to_string(verdict.failed_rank) + ", there: rank " +
                         std::to_string(model) + ")"};
  return verdict;
}

void Engine::obey(Round& round, Verdict verdict, Orders orders) {
  if (verdict.failure.failed()) {
    broken_ = true;
    const std::exception_ptr own = own_exception_;
    const bool mine = verdict.failed_rank == rank() && failure_.kind == Failure::Kind::compute;
    failure_ = {};
    own_exception_ = nullptr;
    if (mine && own) std::rethrow_exception(own);
    const std::string role = cast_.describe(verdict.failed_rank);
    const std::string who =
        "rank " + std::to_string(verdict.failed_rank) + " (" + role + "), frame " + std::to_string(frame_);
    const std::string text = verdict.failure.kind == Failure::Kind::mismatch
                                 ? who + ": its script differs from the other ranks': " + verdict.failure.text
                                 : who + ", " + verdict.failure.action + ": " + verdict.failure.text;
    throw Agreed(std::move(verdict), frame_, role, text);
  }
  for (std::size_t i = 0; i < systems_.size(); ++i) systems_[i]->spawned += verdict.spawned[i];
  for (std::size_t i = round.first; i < round.last; ++i) {
    systems_[i]->alive = verdict.alive[i];
    digests_[i] = verdict.digests[i];
  }
  round.verdict = std::move(verdict);
  round.orders = std::move(orders);
}

}  // namespace motes::frame
