#include "engine/log/account.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/enumerators.h"
#include "engine/state/walls.h"

namespace motes::engine {
namespace {

void note_drawings(const Drawings& drawing, FrameRow& row) {
  if (drawing.width == 0) return;
  row.render_path = base::name_of(drawing.path);
  row.records = drawing.records;
  row.record_bytes = drawing.record_bytes;
  row.render_bytes = drawing.bytes;
}

}  // namespace

Opening opening_of(const Logging& logging) {
  const std::uint64_t first = logging.continued_from;
  if (!logging.lost.empty()) return {"recovered", first, logging.lost};
  if (first == 0) return {"start", 0, ""};
  const std::size_t ranks = logging.hosts.size();
  return {"continued", first,
          "from the checkpoint of frame " + std::to_string(first) + " on " + std::to_string(ranks) +
              (ranks == 1 ? " rank" : " ranks")};
}

void Account::open_log(const Logging& logging) {
  const std::uint64_t first = logging.continued_from;
  log_ = std::make_unique<Log>(logging.directory, logging.hosts, first);
  for (const Opening& earlier : logging.openings) {  // rewrite those that were removed with the rows of later frames
    if (earlier.frame >= first) log_->event(earlier.kind, first, earlier.text);
  }
  const Opening opening = opening_of(logging);
  log_->event(opening.kind, opening.frame, opening.text);
}

void Account::note_links(const std::vector<Link>& links) {
  if (log_) log_->add(links);
}

void Account::note_round(const Script& script, const Round& round, const Judged& judged, const roles::Cast& cast,
                         const roles::Tree& tree) {
  if (round.first == 0) {
    row_ = {};
    row_.frame = script.record.frame;
    row_.time = static_cast<double>(script.record.frame + 1) * script.record.dt;
    row_.load.reserve(script.systems.size() * cast.calculators.size());
  }
  for (std::size_t i = round.first; i < round.last; ++i) {
    row_.particles += round.verdict.alive[i];
    row_.digests.push_back(round.verdict.digests[i]);
    note_loads(*script.systems[i], judged.loads, i - round.first, cast, tree);
  }
}

void Account::note_births(Births by) { row_.births_by = base::name_of(by); }

void Account::note_loads(const System& system, const Loads& loads, std::size_t number, const roles::Cast& cast,
                         const roles::Tree& tree) {
  for (std::size_t c = 0; c < cast.calculators.size(); ++c) {
    const CalculatorLoad& from = loads.of(tree, static_cast<int>(c), number);
    LoadRow load;
    load.system = system.definition.name;
    load.rank = cast.calculators[c];
    load.tally = {from.at_start, from.created, from.killed, from.sent, from.received, 0, from.compute_s};
    load.n_end = std::uint64_t{from.stayed} + from.received;
    const std::uint64_t processed = load.tally.at_start + load.tally.created;
    load.rescaled_s = balance::rescaled(from.compute_s, processed, load.n_end);
    load.speed = from.compute_s > 0 ? static_cast<double>(processed) / from.compute_s : 0;
    load.domain = system.domains.box(static_cast<int>(c));
    if (system.definition.axes.first() >= domains::kById) {
      load.domain.low[0] = system.domains.low(static_cast<int>(c));
      load.domain.high[0] = system.domains.high(static_cast<int>(c));
    }
    load.axes = system.definition.axes;
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

void Account::close_row(const Script& script, const roles::Cast& cast, bool digest) {
  note_imbalance(cast);
  for (const auto& system : script.systems) row_.dropped += system->counts.dropped;
  for (const PressedWall& wall : script.walls)
    row_.walls.push_back({shapes::name(wall.shape.kind), mean_of(wall.sum, script.record.substeps)});
  row_.systems = row_.digests.size();
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

void Account::note_tail(const Tail& tail) {
  if (!open_row_) return;
  FrameRow& row = *open_row_;
  row.has_tail = tail.valid && tail.frame == row.frame;
  if (row.has_tail) {
    row.times = tail.times;
    row.times.frame = tail.ended_s - std::exchange(ended_s_, tail.ended_s);
    row.image_sha256 = tail.image_sha256;
    row.exchanged += tail.moved;
    row.exchanged_bytes = tail.exchanged_bytes;
    note_drawings(tail.drawings, row);
    for (std::size_t i = 0; i < row.digests.size() && i < tail.children.size(); ++i) row.digests[i] += tail.children[i];
  }
  last_row_ = std::move(row);
  row_is_new_ = true;
  open_row_.reset();
}

void Account::note_tails(const std::vector<CalculatorTail>& tails, const roles::Tree& tree) {
  if (!last_row_ || !row_is_new_) return;
  FrameRow& row = *last_row_;
  if (!row.has_tail || tails.empty() || tails.size() != row.load.size()) return;
  const std::size_t calculators = row.load.size() / row.systems;
  for (std::size_t i = 0; i < tails.size(); ++i) {
    const auto place = static_cast<std::size_t>(tree.row_of(static_cast<int>(i % calculators)));
    const CalculatorTail& of = tails[place * row.systems + i / calculators];
    LoadRow& load = row.load[i];
    load.tally.sent += of.interaction.moved_out;
    load.tally.received += of.interaction.moved_in;
    load.tally.bytes_sent = of.bytes_sent;
    load.density.particles = of.particles;
    std::copy(std::begin(of.quantiles), std::end(of.quantiles), load.density.quantiles);
    load.exchange_s = double{of.exchange_s};
    load.image_s = double{of.image_s};
    load.wait_s = double{of.wait_s};
    load.project_s = double{of.project_s};
    load.pack_s = of.pack_s;
    load.unpack_s = of.unpack_s;
    load.search_s = of.search_s;
    load.migrant_bytes = of.migrant_bytes;
    load.ways = of.ways;
    load.interaction = of.interaction;
  }
}

void Account::note_times(std::vector<RankTimes> times) {
  if (last_row_ && row_is_new_ && last_row_->has_tail) last_row_->ranks = std::move(times);
}

void Account::write_rows() {
  if (log_ && row_is_new_ && last_row_) log_->add(*last_row_);
  row_is_new_ = false;
}

void Account::secure_rows() {
  write_rows();
  if (log_) log_->sync();
}

}  // namespace motes::engine
