// The manager's account of a frame: reports become rows of the log. What a rank did after its report (exchange,
// render) it tells with its next report, so a frame's row is whole one turn later.
#include <algorithm>

#include "frame/engine.h"

namespace motes::frame {
namespace {

double seconds_of(const Report& report) {
  double sum = 0;
  for (const SystemReport& system : report.systems) sum += system.compute_s;
  return sum;
}

// Processing time in proportion to the particles held after the exchange (paper 3.2.4).
double rescaled(double seconds, std::uint64_t before, std::uint64_t after) {
  return before == 0 ? seconds : seconds * static_cast<double>(after) / static_cast<double>(before);
}

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

void Engine::note_frame(const std::vector<Report>& reports, const Verdict& verdict) {
  if (!in_frame()) return;
  FrameRow row;
  row.frame = frame_;
  row.time = static_cast<double>(frame_ + 1) * options_.dt;
  for (const std::uint64_t alive : verdict.alive) row.particles += alive;
  for (const auto& system : systems_) row.dropped += system->dropped;
  if (options_.digest) row.particles_digest = particles::combine(verdict.digests).text();
  note_imbalance(reports, row);
  for (std::size_t i = 0; i < systems_.size(); ++i) note_loads(reports, i, row);
  open_row_ = std::move(row);
}

void Engine::note_imbalance(const std::vector<Report>& reports, FrameRow& row) const {
  double sum = 0;
  double slowest = 0;
  for (const int rank : cast_.calculators) {
    const double seconds = seconds_of(reports[static_cast<std::size_t>(rank)]);
    sum += seconds;
    if (seconds < slowest) continue;
    slowest = seconds;
    row.slowest_rank = rank;
  }
  if (sum > 0) row.imbalance = slowest * static_cast<double>(cast_.calculators.size()) / sum;
}

void Engine::note_loads(const std::vector<Report>& reports, std::size_t system, FrameRow& row) const {
  std::vector<std::uint64_t> received(cast_.calculators.size(), 0);
  for (const int rank : cast_.calculators) {
    for (const Sent& sent : reports[static_cast<std::size_t>(rank)].systems[system].sent) {
      received[static_cast<std::size_t>(sent.domain)] += sent.count;
    }
  }
  const System& s = *systems_[system];
  for (std::size_t c = 0; c < cast_.calculators.size(); ++c) {
    const SystemReport& from = reports[static_cast<std::size_t>(cast_.calculators[c])].systems[system];
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
    load.rescaled_s = rescaled(from.compute_s, processed, load.n_end);
    load.speed = from.compute_s > 0 ? static_cast<double>(processed) / from.compute_s : 0;
    load.domain_lo = s.domains.low(static_cast<int>(c));
    load.domain_hi = s.domains.high(static_cast<int>(c));
    row.exchanged += load.sent;
    row.load.push_back(std::move(load));
  }
}

void Engine::note_tails(const std::vector<Report>& reports) {
  if (!open_row_) return;
  FrameRow& row = *open_row_;
  for (std::size_t rank = 0; rank < reports.size(); ++rank) {
    const Tail& tail = reports[rank].tail;
    if (!tail.valid || tail.frame != row.frame) continue;
    take_larger(row.times, tail.times);
    if (!tail.image_sha256.empty()) row.image_sha256 = tail.image_sha256;
    std::size_t system = 0;
    for (LoadRow& load : row.load) {
      if (load.rank != static_cast<int>(rank)) continue;
      load.bytes_sent = system < tail.bytes_sent.size() ? tail.bytes_sent[system] : 0;
      load.exchange_s = tail.times.exchange;
      load.image_s = tail.times.render;
      load.wait_s = tail.times.wait;
      row.exchanged_bytes += load.bytes_sent;
      ++system;
    }
  }
  if (log_) log_->add(row);
  last_row_ = std::move(row);
  open_row_.reset();
}

}  // namespace motes::frame
