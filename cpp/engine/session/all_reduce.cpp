#include "engine/session/all_reduce.h"

#include <algorithm>
#include <utility>

namespace motes::engine {

using comm::Message;
using comm::Phase;

Maxima all_reduce_max(Rank& rank, const Round& round, Maxima numbers) {
  Session& session = rank.session;
  const int count = static_cast<int>(session.calculators());
  const int self = session.calculator();
  for (int ahead = 1; ahead < count; ahead *= 2) {
    const int to = session.rank_of((self + ahead) % count);
    const int from = session.rank_of((self + count - ahead) % count);
    session.comm().await(from, Phase::all_reduce);
    Message message;
    message.bytes().put_raw(numbers.data(), numbers.size() * sizeof(float));
    session.comm().post(to, Phase::all_reduce, session.stamp(round), std::move(message));
    const Message other = session.comm().expect(from, Phase::all_reduce, session.stamp(round));
    base::Reader in = other.reader();
    for (std::size_t i = 0; i < numbers.size() && !in.done(); ++i) numbers[i] = std::max(numbers[i], in.get<float>());
  }
  return numbers;
}

std::uint64_t all_reduce_sum(Rank& rank, const Round& round, Phase phase, std::vector<std::int64_t>& numbers) {
  comm::Communicator& comm = rank.session.comm();
  const auto count = static_cast<std::size_t>(rank.session.calculators());
  const auto self = static_cast<std::size_t>(rank.session.calculator());
  std::uint64_t bytes = 0;
  const auto first = [&](std::size_t part) { return numbers.size() * part / count; };
  const auto send = [&](std::size_t to, std::size_t part) {
    Message message;
    message.bytes().put_raw(&numbers[first(part)], (first(part + 1) - first(part)) * sizeof(std::int64_t));
    bytes += message.payload().size();
    comm.post(rank.session.rank_of(static_cast<int>(to)), phase, rank.session.stamp(round), std::move(message), 0,
              rank.session.failed());
  };
  const auto hear = [&](std::size_t from, std::size_t part, bool adds) {
    const Message message = comm.expect(rank.session.rank_of(static_cast<int>(from)), phase, rank.session.stamp(round));
    base::Reader in = message.reader();
    for (std::size_t i = first(part); i < first(part + 1); ++i) {
      numbers[i] = in.get<std::int64_t>() + (adds ? numbers[i] : 0);
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
