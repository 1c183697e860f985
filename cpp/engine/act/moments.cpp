#include "engine/act/moments.h"

#include <utility>

namespace motes::engine {

using comm::Message;
using comm::Phase;

std::uint64_t add_moments(Rank& rank, const Round& round, interactions::Moments& moments) {
  comm::Communicator& comm = rank.talk.comm();
  const auto count = static_cast<std::size_t>(rank.talk.calculators());
  const auto self = static_cast<std::size_t>(rank.talk.calculator());
  std::uint64_t bytes = 0;
  const auto first = [&](std::size_t part) { return moments.size() * part / count; };
  const auto send = [&](std::size_t to, std::size_t part) {
    Message message;
    message.bytes().put_raw(&moments[first(part)], (first(part + 1) - first(part)) * sizeof(std::int64_t));
    bytes += message.payload().size();
    comm.post(rank.talk.rank_of(static_cast<int>(to)), Phase::meeting, rank.talk.stamp(round), std::move(message), 0,
              rank.talk.failed());
  };
  const auto hear = [&](std::size_t from, std::size_t part, bool adds) {
    const Message message =
        comm.expect(rank.talk.rank_of(static_cast<int>(from)), Phase::meeting, rank.talk.stamp(round));
    base::Reader in = message.reader();
    for (std::size_t i = first(part); i < first(part + 1); ++i) {
      moments[i] = in.get<std::int64_t>() + (adds ? moments[i] : 0);
    }
  };
  for (std::size_t step = 1; step < count; ++step) send((self + step) % count, (self + step) % count);
  for (std::size_t step = 1; step < count; ++step) hear((self + count - step) % count, self, true);
  for (std::size_t step = 1; step < count; ++step) send((self + step) % count, self);
  for (std::size_t step = 1; step < count; ++step) {
    hear((self + count - step) % count, (self + count - step) % count, false);
  }
  return bytes;
}

}  // namespace motes::engine
