#include "engine/sums/notes.h"

#include <span>
#include <utility>

#include "engine/sums/sums.h"

namespace motes::engine {

Notes exchange_notes(Rank& rank, Note own) {
  Conversation& talk = rank.talk;
  Notes notes;
  notes.totals = std::get<std::vector<std::int64_t>>(total_of_all(rank, program::Summed(std::move(own.numbers))));
  talk.relay().say(comm::Phase::notes, talk.stamp(), std::as_bytes(std::span(own.text)), false);
  talk.relay().hand_up(comm::Phase::notes, talk.stamp());
  if (!talk.manages()) return notes;
  for (const Said& said : talk.relay().listen(comm::Phase::notes, talk.stamp()).ranks) {
    notes.texts.emplace_back(reinterpret_cast<const char*>(said.bytes.data()), said.bytes.size());
  }
  return notes;
}

}  // namespace motes::engine
