#include "engine/session/reports.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "base/fields.h"

namespace motes::engine {

using base::Bytes;
using comm::Message;
using comm::Phase;

namespace {

// Calculators' rows are sent as raw memory, so ranks in between can forward them unread.
static_assert(base::copied_whole<CalculatorLoad>() && base::copied_whole<CalculatorTail>());

template <class T>
void put_all(const std::vector<T>& values, Bytes& out) {
  out.put_raw(values.data(), values.size() * sizeof(T));
}

template <class T>
void take_all(std::span<const std::byte> bytes, std::vector<T>& into) {
  if (bytes.size() % sizeof(T) != 0) throw std::runtime_error("a message has an incomplete row of a calculator");
  const std::size_t before = into.size();
  into.resize(before + bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(into.data() + before, bytes.data(), bytes.size());
}

// Separates the flows that stay within this subtree from those to report further up.
void keep_flows(const roles::Tree& tree, Gathered& gathered) {
  std::vector<Flow>& flows = gathered.report.flows;
  const auto leaves = [&](const Flow& flow) { return !tree.holds(tree.own(), static_cast<int>(flow.to)); };
  const auto staying = std::stable_partition(flows.begin(), flows.end(), leaves);
  gathered.staying.assign(staying, flows.end());
  flows.erase(staying, flows.end());
}

// Adds the flows within this subtree to CalculatorLoad::received. `rows`: `systems` loads per calculator.
void count_arrivals(const roles::Tree& tree, const std::vector<Flow>& staying, std::size_t systems, std::byte* rows) {
  for (const Flow& flow : staying) {
    const auto row = static_cast<std::size_t>(tree.row_of(static_cast<int>(flow.to)));
    std::byte* const at = rows + (row * systems + flow.system) * sizeof(CalculatorLoad);
    CalculatorLoad load;
    std::memcpy(&load, at, sizeof load);
    load.received += flow.count;
    std::memcpy(at, &load, sizeof load);
  }
}

void check_rows(std::size_t rows, std::size_t calculators, std::size_t systems) {
  if (rows != calculators * systems) throw std::runtime_error("reports have too few or too many rows of calculators");
}

// Appends one block per rank: the rank, its times, then its calculator's rows.
void put_tails(int rank, const comm::Spent& spent, const std::vector<CalculatorTail>& tails, Bytes& out) {
  out.put(static_cast<std::int32_t>(rank));
  out.put(static_cast<std::uint32_t>(spent.waits.size()));
  out.put(static_cast<std::uint32_t>(tails.size()));
  for (const double seconds : spent.activities) out.put(seconds);
  for (const double seconds : {spent.wall_s, spent.messages_s, spent.chain_s, spent.script_idle_s}) out.put(seconds);
  for (const comm::Waited& wait : spent.waits) {
    for (const std::int32_t number : {wait.late, wait.sender, wait.phase}) out.put(number);
    out.put(wait.seconds);
  }
  put_all(tails, out);
}

void take_tails(base::Reader& in, AllTails& all) {
  RankTimes times;
  times.rank = in.get<std::int32_t>();
  const auto waits = in.get<std::uint32_t>();
  const auto tails = in.get<std::uint32_t>();
  comm::Spent& spent = times.spent;
  for (double& seconds : spent.activities) seconds = in.get<double>();
  for (double* const seconds : {&spent.wall_s, &spent.messages_s, &spent.chain_s, &spent.script_idle_s}) {
    *seconds = in.get<double>();
  }
  spent.waits.resize(waits);
  for (comm::Waited& wait : spent.waits) {
    for (std::int32_t* const number : {&wait.late, &wait.sender, &wait.phase}) *number = in.get<std::int32_t>();
    wait.seconds = in.get<double>();
  }
  take_all(in.take(tails * sizeof(CalculatorTail)), all.calculators);
  all.times.push_back(std::move(times));
}

void pass_tails(Rank& rank, const Round& round) {
  Message message;
  put_tails(rank.session.rank(), round.own_spent, round.own_tails, message.bytes());
  for (const Message& below : rank.session.relay().from_below(Phase::log, rank.session.stamp(round))) {
    message.bytes().put_raw(below.payload().data(), below.payload().size());
  }
  rank.session.relay().pass_up(Phase::log, rank.session.stamp(round), std::move(message), false);
}

}  // namespace

void send_report(Rank& rank, const Round& round) {
  Relay& relay = rank.session.relay();
  relay.await_below(Phase::report);
  if (round.tells_tails) relay.await_below(Phase::log);
  if (!relay.tree().leaf() || relay.tree().root()) return;
  Message message;
  write(round.own, message.bytes());
  if (!round.own.failed()) put_all(round.own_loads, message.bytes());
  relay.pass_up(Phase::report, rank.session.stamp(round), std::move(message), round.own.failed());
  if (round.tells_tails) pass_tails(rank, round);
}

Gathered gather_reports(Rank& rank, Round& round) {
  Gathered gathered;
  gathered.report = std::move(round.own);
  gathered.below = rank.session.relay().from_below(Phase::report, rank.session.stamp(round));
  for (const Message& message : gathered.below) {
    base::Reader in = message.reader();
    join(gathered.report, read_report(in));
    gathered.loads.push_back(in.take(in.left()));
  }
  const auto read =
      static_cast<double>(gathered.below.size() * std::max<std::size_t>(1, gathered.report.systems.size()));
  rank.machine.charge_once(rank.machine.costs().report * read);
  if (!gathered.report.failed()) keep_flows(rank.session.relay().tree(), gathered);
  return gathered;
}

std::vector<Flow> pass_reports(Rank& rank, Round& round) {
  Relay& relay = rank.session.relay();
  if (relay.tree().leaf()) return {};
  Gathered gathered = gather_reports(rank, round);
  Message message;
  write(gathered.report, message.bytes());
  if (!gathered.report.failed()) {
    const std::size_t rows = message.bytes().size();
    put_all(round.own_loads, message.bytes());
    for (const auto loads : gathered.loads) message.bytes().put_raw(loads.data(), loads.size());
    count_arrivals(relay.tree(), gathered.staying, gathered.report.systems.size(), message.bytes().data() + rows);
    rank.machine.charge_once(rank.machine.costs().report_byte * static_cast<double>(message.bytes().size() - rows));
  }
  relay.pass_up(Phase::report, rank.session.stamp(round), std::move(message), gathered.report.failed());
  if (round.tells_tails) pass_tails(rank, round);
  return std::move(gathered.staying);
}

Loads loads_of(const Rank& rank, const Round& round, const Gathered& gathered) {
  Loads loads;
  loads.systems = gathered.report.systems.size();
  loads.rows = round.own_loads;
  for (const auto below : gathered.loads) take_all(below, loads.rows);
  check_rows(loads.rows.size(), rank.session.calculators(), loads.systems);
  count_arrivals(rank.session.relay().tree(), gathered.staying, loads.systems,
                 reinterpret_cast<std::byte*>(loads.rows.data()));
  return loads;
}

AllTails gather_tails(Rank& rank, comm::Stamp stamp, std::vector<CalculatorTail> own, comm::Spent own_spent) {
  AllTails all{std::move(own), {{rank.session.rank(), std::move(own_spent)}}};
  for (const Message& below : rank.session.relay().from_below(Phase::log, stamp)) {
    base::Reader in = below.reader();
    while (!in.done()) take_tails(in, all);
  }
  std::sort(all.times.begin(), all.times.end(), [](const RankTimes& a, const RankTimes& b) { return a.rank < b.rank; });
  return all;
}

}  // namespace motes::engine
