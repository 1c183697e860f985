// The manager's account of a frame: reports become rows of the log. What a rank did after its report (exchange,
// render) it tells with its next report, so a frame's row is whole one turn later.
#include <algorithm>

#include "frame/engine.h"

namespace motes::frame {
namespace {

void take_larger(PhaseTimes& most, const PhaseTimes& times) {
  most.create = std::max(most.create, times.create);
  most.act = std::max(most.act, times.act);
  most.report = std::max(most.report, times.report);
  most.exchange = std::max(most.exchange, times.exchange);
  most.balance = std::max(most.balance, times.balance);
  most.render = std::max(most.render, times.render);
  most.wait = std::max(most.wait, times.wait);
  most.frame = std::max(most.frame, times.frame);
}

}  // namespace

// One round of a frame; the row is complete, but for the tails, with its last one.
void Engine::note_round(const Round& round, const std::vector<Report>& reports, const Verdict& verdict) {
  if (!in_frame()) return;
  if (round.first == 0) {
    row_ = {};
    row_.frame = frame_;
    row_.time = static_cast<double>(frame_ + 1) * options_.dt;
    row_digests_.clear();
    for (const auto& system : systems_) row_.dropped += system->dropped;
  }
  for (std::size_t i = round.first; i < round.last; ++i) {
    row_.particles += verdict.alive[i];
    row_digests_.push_back(verdict.digests[i]);
    note_loads(reports, i, round.first);
  }
  if (round.last < systems_.size()) return;
  if (options_.digest) row_.particles_digest = particles::combine(row_digests_).text();
  note_imbalance();
  open_row_ = std::move(row_);
}

void Engine::note_imbalance() {
  const std::size_t calculators = cast_.calculators.size();
  std::vector<double> seconds(calculators, 0.0);
  for (std::size_t i = 0; i < row_.load.size(); ++i) seconds[i % calculators] += row_.load[i].compute_s;
  double sum = 0;
  for (const double s : seconds) sum += s;
  const auto slowest = std::max_element(seconds.begin(), seconds.end());
  row_.slowest_rank = cast_.calculators[static_cast<std::size_t>(slowest - seconds.begin())];
  if (sum > 0) row_.imbalance = *slowest * static_cast<double>(calculators) / sum;
}

void Engine::note_loads(const std::vector<Report>& reports, std::size_t index, std::size_t first) {
  std::vector<std::uint64_t> received(cast_.calculators.size(), 0);
  for (const int rank : cast_.calculators) {
    for (const Sent& sent : reports[static_cast<std::size_t>(rank)].systems[index - first].sent) {
      received[static_cast<std::size_t>(sent.domain)] += sent.count;
    }
  }
  System& s = *systems_[index];
  row_.load.reserve(systems_.size() * cast_.calculators.size());
  s.loads.assign(cast_.calculators.size(), {});
  for (std::size_t c = 0; c < cast_.calculators.size(); ++c) {
    const SystemReport& from = reports[static_cast<std::size_t>(cast_.calculators[c])].systems[index - first];
    LoadRow load;
    load.system = s.definition.name;
    load.rank = cast_.calculators[c];
    load.n_start = from.at_start;
    load.created = from.created;
    load.killed = from.killed;
    for (const Sent& sent : from.sent) load.sent += sent.count;
    load.received = received[c];
    load.n_end = from.kept + received[c];
    load.compute_s = from.compute_s;
    const std::uint64_t processed = from.at_start + from.created;
    load.rescaled_s = balance::rescaled(from.compute_s, processed, load.n_end);
    load.speed = from.compute_s > 0 ? static_cast<double>(processed) / from.compute_s : 0;
    load.domain_lo = s.domains.low(static_cast<int>(c));
    load.domain_hi = s.domains.high(static_cast<int>(c));
    if (balances()) {
      s.speeds.add(static_cast<int>(c), processed, from.compute_s, from.created);
      s.loads[c] = {load.n_end, load.rescaled_s, s.speeds.of(static_cast<int>(c)), s.speeds.error(static_cast<int>(c))};
    }
    row_.exchanged += load.sent;
    row_.load.push_back(std::move(load));
  }
}

void Engine::note_tails(const std::vector<Report>& reports) {
  if (!open_row_) return;
  FrameRow& row = *open_row_;
  for (std::size_t rank = 0; rank < reports.size(); ++rank) {
    const Tail& tail = reports[rank].tail;
    if (tail.valid && tail.frame == row.frame) note_tail(static_cast<int>(rank), tail, row);
  }
  last_row_ = std::move(row);
  row_is_new_ = true;
  open_row_.reset();
}

// A row is written a turn after it is whole: nobody waits for the disk then.
void Engine::write_rows() {
  if (log_ && row_is_new_ && last_row_) log_->add(*last_row_);
  row_is_new_ = false;
}

void Engine::note_tail(int rank, const Tail& tail, FrameRow& row) {
  take_larger(row.times, tail.times);
  if (!tail.image_sha256.empty()) row.image_sha256 = tail.image_sha256;
  const int calculator = cast_.calculator_of(rank);
  if (calculator < 0) return;
  std::size_t at = static_cast<std::size_t>(calculator);
  for (std::size_t system = 0; at < row.load.size(); ++system, at += cast_.calculators.size()) {
    LoadRow& load = row.load[at];
    load.bytes_sent = system < tail.bytes_sent.size() ? tail.bytes_sent[system] : 0;
    if (system < tail.density.size()) load.density = tail.density[system];
    load.exchange_s = tail.times.exchange;
    load.image_s = tail.times.render;
    load.wait_s = tail.times.wait;
    row.exchanged_bytes += load.bytes_sent;
  }
}

}  // namespace motes::frame
