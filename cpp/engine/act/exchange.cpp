#include "engine/act/exchange.h"

namespace motes::engine {

using comm::Message;
using comm::Phase;

void send_migrants(Rank& rank, const Script& script, const Calculator& calculator, Round& round) {
  Session& session = rank.session;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::exchange, "send migrants", script.name_of(round));
  for (const std::int32_t sender : round.orders.senders) session.comm().await(sender, Phase::exchange);
  std::map<int, std::uint64_t> counts;
  for (std::size_t i = round.first; i < round.last; ++i) {
    for (const Sent& s : calculator.populations[i]->sent) counts[s.domain] += s.count;
  }
  for (auto& [to, message] : round.leaving) {
    session.comm().post(session.rank_of(to), Phase::exchange, session.stamp(round), std::move(message), counts[to]);
  }
  round.leaving.clear();
}

void receive_arrivals(Rank& rank, const Script& script, Calculator& calculator, const Round& round) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::exchange, "receive", script.name_of(round));
  for (const std::int32_t sender : round.orders.senders) {
    const Message message = rank.session.comm().expect(sender, Phase::exchange, rank.session.stamp(round));
    rank.session.work("exchange", [&] {
      base::Reader in = message.reader();
      std::uint64_t count = 0;
      while (!in.done()) {
        Population& here = *calculator.populations.at(in.get<std::uint32_t>());
        const std::size_t before = here.store.size();
        const double start = rank.machine.compute_seconds();
        here.store.unpack(in, *rank.pool);
        const std::size_t arrived = here.store.size() - before;
        rank.machine.charge(rank.machine.costs().arrive * static_cast<double>(arrived));
        here.handling.unpack.add(arrived, rank.machine.compute_seconds() - start);
        count += arrived;
      }
      if (count != message.header().count)
        throw std::runtime_error("particles were lost on the way between calculators");
    });
  }
}

}  // namespace motes::engine
