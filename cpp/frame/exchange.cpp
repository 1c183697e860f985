// exchange (paper 3.2.4): particles that left their domain go straight to their owner, all systems in one message.
#include "comm/clock.h"
#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using comm::Message;
using comm::Phase;

void Engine::exchange() {
  const double start = comm::wall_seconds();
  exchange_bytes_.assign(systems_.size(), 0);
  for (std::size_t c = 0; c < leaving_.size(); ++c) {
    std::uint64_t count = 0;
    for (const std::vector<Sent>& sent : sent_) {
      for (const Sent& s : sent) count += s.domain == static_cast<std::int32_t>(c) ? s.count : 0;
    }
    if (count > 0) comm_->post(cast_.calculators[c], Phase::exchange, stamp(), std::move(leaving_[c]), count);
  }
  for (const std::int32_t source : verdict_.sources) {
    const Message message = comm_->expect(source, Phase::exchange, stamp());
    work("exchange", [&] {
      particles::Reader in = message.reader();
      std::uint64_t count = 0;
      for (const auto& system : systems_) {
        const std::size_t before = system->store->size();
        system->store->unpack(in);
        system->tally.received += system->store->size() - before;
        count += system->store->size() - before;
      }
      if (count != message.header().count)
        throw std::runtime_error("particles were lost on the way between calculators");
    });
  }
  for (std::size_t i = 0; i < systems_.size(); ++i) exchange_bytes_[i] = systems_[i]->tally.bytes_sent;
  leaving_.clear();
  times_.exchange = comm::wall_seconds() - start;
}

}  // namespace motes::frame
