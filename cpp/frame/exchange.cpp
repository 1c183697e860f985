// exchange (paper 3.2.4): particles that left their domain go straight to their owner, all systems in one message.
#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using comm::Message;
using comm::Phase;

void Engine::send_leavers(Round& round) {
  const Timed timed(*this, times_.exchange, "send leavers", name_of(round));
  for (const std::int32_t source : round.orders.sources) comm_->await(source, Phase::exchange);
  std::map<int, std::uint64_t> counts;
  for (std::size_t i = round.first; i < round.last; ++i) {
    for (const Sent& s : systems_[i]->sent) counts[s.domain] += s.count;
  }
  for (auto& [to, message] : round.leaving) {
    const int rank = cast_.calculators[static_cast<std::size_t>(to)];
    comm_->post(rank, Phase::exchange, stamp(round), std::move(message), counts[to]);
  }
  round.leaving.clear();
}

void Engine::receive_strangers(Round& round) {
  const Timed timed(*this, times_.exchange, "receive", name_of(round));
  exchange_bytes_.resize(systems_.size());
  for (const std::int32_t source : round.orders.sources) {
    const Message message = comm_->expect(source, Phase::exchange, stamp(round));
    work("exchange", [&] {
      particles::Reader in = message.reader();
      std::uint64_t count = 0;
      while (!in.done()) {
        System& system = *systems_.at(in.get<std::uint32_t>());
        const std::size_t before = system.store->size();
        system.store->unpack(in);
        system.tally.received += system.store->size() - before;
        count += system.store->size() - before;
      }
      charge(options_.costs.arrive * static_cast<double>(count));
      if (count != message.header().count)
        throw std::runtime_error("particles were lost on the way between calculators");
    });
  }
  for (std::size_t i = round.first; i < round.last; ++i) exchange_bytes_[i] = systems_[i]->tally.bytes_sent;
}

}  // namespace motes::frame
