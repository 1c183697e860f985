// gather: all particles of a system on one rank, or on all.
#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using comm::Phase;

std::unique_ptr<particles::Store> Engine::gather(int index, bool to_all) {
  catch_up();
  converse(recording::Verb::gather, system(index).definition.name + (to_all ? ", to all" : ", to rank 0"));
  const particles::Store& store = *system(index).store;
  if (calculator() >= 0) {
    std::vector<std::uint32_t> everyone(store.size());
    for (std::size_t i = 0; i < everyone.size(); ++i) everyone[i] = static_cast<std::uint32_t>(i);
    particles::Bytes packed;
    store.pack(everyone, packed);
    for (int to = 0; to < (to_all ? comm_->size() : 1); ++to) {
      comm::Message message;
      message.bytes().put_raw(packed.data(), packed.size());
      comm_->post(to, Phase::gather, stamp(), std::move(message), store.size());
    }
  }
  if (!to_all && rank() != 0) return nullptr;
  auto gathered = std::make_unique<particles::Store>(system(index).schema);
  for (const int from : cast_.calculators) {
    const comm::Message message = comm_->expect(from, Phase::gather, stamp());
    particles::Reader in = message.reader();
    gathered->unpack(in);
  }
  return gathered;
}

}  // namespace motes::frame
