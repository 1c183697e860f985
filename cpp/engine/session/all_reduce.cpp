#include "engine/session/all_reduce.h"

#include <algorithm>
#include <utility>

namespace motes::engine {

using comm::Message;
using comm::Phase;

Maxima all_reduce_max(Rank& rank, const Round& round, Maxima word) {
  Conversation& talk = rank.talk;
  const int count = static_cast<int>(talk.calculators());
  const int self = talk.calculator();
  for (int ahead = 1; ahead < count; ahead *= 2) {
    const int to = talk.rank_of((self + ahead) % count);
    const int from = talk.rank_of((self + count - ahead) % count);
    talk.comm().await(from, Phase::word);
    Message message;
    message.bytes().put_raw(word.data(), word.size() * sizeof(float));
    talk.comm().post(to, Phase::word, talk.stamp(round), std::move(message));
    const Message heard = talk.comm().expect(from, Phase::word, talk.stamp(round));
    base::Reader in = heard.reader();
    for (std::size_t i = 0; i < word.size() && !in.done(); ++i) word[i] = std::max(word[i], in.get<float>());
  }
  return word;
}

}  // namespace motes::engine
