#include "frame/account.h"

#include <algorithm>
#include <utility>

#include "particles/enumerators.h"

namespace motes::frame {
namespace {

void take_larger(PhaseTimes& most, const PhaseTimes& times) {
  for (const auto seconds : {&PhaseTimes::create, &PhaseTimes::act, &PhaseTimes::report, &PhaseTimes::exchange,
                             &PhaseTimes::balance, &PhaseTimes::render, &PhaseTimes::project, &PhaseTimes::draw,
                             &PhaseTimes::assemble, &PhaseTimes::wait, &PhaseTimes::frame}) {
    most.*seconds = std::max(most.*seconds, times.*seconds);
  }
}

void note_drawing(const Drawing& drawing, FrameRow& row) {
  if (drawing.width == 0) return;
  row.render_path = particles::name_of(drawing.path);
  row.records += drawing.records;
  row.render_bytes += drawing.bytes;
}

}  // namespace

void Account::open_log(const std::string& directory, const std::vector<std::string>& hosts) {
  log_ = std::make_unique<Log>(directory, hosts);
}

void Account::note_round(const Script& script, const Round& round, const std::vector<Report>& reports,
                         const Verdict& verdict, const roles::Cast& cast) {
  if (round.first == 0) {
    row_ = {};
    row_.frame = script.record.frame;
    row_.time = static_cast<double>(script.record.frame + 1) * script.record.dt;
    row_.load.reserve(script.systems.size() * cast.calculators.size());
    for (const auto& system : script.systems) row_.dropped += system->counts.dropped;
  }
  for (std::size_t i = round.first; i < round.last; ++i) {
    row_.particles += verdict.alive[i];
    row_.digests.push_back(verdict.digests[i]);
    note_loads(script, reports, i, round.first, cast);
  }
}

void Account::note_loads(const Script& script, const std::vector<Report>& reports, std::size_t index, std::size_t first,
                         const roles::Cast& cast) {
  std::vector<std::uint64_t> received(cast.calculators.size(), 0);
  for (const int rank : cast.calculators) {
    for (const Sent& sent : reports[static_cast<std::size_t>(rank)].systems[index - first].sent) {
      received[static_cast<std::size_t>(sent.domain)] += sent.count;
    }
  }
  const System& s = *script.systems[index];
  for (std::size_t c = 0; c < cast.calculators.size(); ++c) {
    const SystemReport& from = reports[static_cast<std::size_t>(cast.calculators[c])].systems[index - first];
    LoadRow load;
    load.system = s.definition.name;
    load.rank = cast.calculators[c];
    load.tally = {from.at_start, from.created, from.killed, 0, received[c], 0, from.compute_s};
    for (const Sent& sent : from.sent) load.tally.sent += sent.count;
    load.n_end = from.kept + received[c];
    const std::uint64_t processed = from.at_start + from.created;
    load.rescaled_s = balance::rescaled(from.compute_s, processed, load.n_end);
    load.speed = from.compute_s > 0 ? static_cast<double>(processed) / from.compute_s : 0;
    load.domain_lo = s.domains.low(static_cast<int>(c));
    load.domain_hi = s.domains.high(static_cast<int>(c));
    row_.exchanged += load.tally.sent;
    row_.load.push_back(std::move(load));
  }
}

void Account::note_children(std::size_t system, int calculator, std::uint64_t count) {
  const std::size_t calculators = row_.load.size() / row_.digests.size();
  LoadRow& load = row_.load[system * calculators + static_cast<std::size_t>(calculator)];
  load.children += count;
  load.n_end += count;
  load.rescaled_s = balance::rescaled(load.tally.compute_s, load.tally.at_start + load.tally.created, load.n_end);
  row_.particles += count;
}

void Account::close_row(const roles::Cast& cast, bool digest) {
  note_imbalance(cast);
  if (!digest) row_.digests.clear();
  open_row_ = std::exchange(row_, {});
}

void Account::note_imbalance(const roles::Cast& cast) {
  const std::size_t calculators = cast.calculators.size();
  std::vector<double> seconds(calculators, 0.0);
  for (std::size_t i = 0; i < row_.load.size(); ++i) seconds[i % calculators] += row_.load[i].tally.compute_s;
  double sum = 0;
  for (const double s : seconds) sum += s;
  const auto slowest = std::max_element(seconds.begin(), seconds.end());
  row_.slowest_rank = cast.calculators[static_cast<std::size_t>(slowest - seconds.begin())];
  if (sum > 0) row_.imbalance = *slowest * static_cast<double>(calculators) / sum;
}

void Account::note_tails(const std::vector<Report>& reports, const roles::Cast& cast) {
  if (!open_row_) return;
  FrameRow& row = *open_row_;
  for (std::size_t rank = 0; rank < reports.size(); ++rank) {
    const Tail& tail = reports[rank].tail;
    if (!tail.valid || tail.frame != row.frame) continue;
    take_larger(row.times, tail.times);
    if (!tail.image_sha256.empty()) row.image_sha256 = tail.image_sha256;
    note_drawing(tail.drawing, row);
    note_tail(cast.calculator_of(static_cast<int>(rank)), tail, row);
  }
  last_row_ = std::move(row);
  row_is_new_ = true;
  open_row_.reset();
}

void Account::note_tail(int calculator, const Tail& tail, FrameRow& row) {
  for (std::size_t i = 0; i < row.digests.size() && i < tail.children.size(); ++i) row.digests[i] += tail.children[i];
  if (calculator < 0) return;
  const std::size_t systems = tail.bytes_sent.size();
  for (std::size_t system = 0; system < systems; ++system) {
    const std::size_t at = system * (row.load.size() / systems) + static_cast<std::size_t>(calculator);
    if (at >= row.load.size()) return;
    LoadRow& load = row.load[at];
    load.tally.bytes_sent = tail.bytes_sent[system];
    if (system < tail.density.size()) load.density = tail.density[system];
    load.exchange_s = tail.times.exchange;
    load.image_s = tail.times.render;
    load.wait_s = tail.times.wait;
    row.exchanged_bytes += load.tally.bytes_sent;
  }
}

void Account::write_rows() {
  if (log_ && row_is_new_ && last_row_) log_->add(*last_row_);
  row_is_new_ = false;
}

}  // namespace motes::frame
