#include "engine/sums/sums.h"

#include <cstring>
#include <span>
#include <stdexcept>
#include <utility>

namespace motes::engine {

using comm::Message;
using comm::Phase;

namespace {

template <class T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

void write(const program::Totals& totals, base::Bytes& out) {
  std::visit([&](const auto& values) { out.put_raw(values.data(), bytes_of(values)); }, totals);
}

// Returns totals of the size and kind of `own`.
program::Totals room_for(const program::Summed& own) {
  if (const auto* counts = std::get_if<std::vector<std::int64_t>>(&own)) return *counts;
  return std::vector<double>(std::get<std::vector<particles::ExactSum>>(own).size());
}

program::Totals read(base::Reader in, const program::Summed& own) {
  program::Totals totals = room_for(own);
  std::visit(
      [&](auto& values) {
        const auto bytes = in.take(bytes_of(values));
        if (!in.done()) throw std::runtime_error("a message has totals of different bins");
        if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
      },
      totals);
  return totals;
}

}  // namespace

program::Totals total_of_all(Rank& rank, program::Summed own) {
  Relay& relay = rank.session.relay();
  for (const Message& below : relay.from_below(Phase::sums, rank.session.stamp())) {
    base::Reader in = below.reader();
    program::add(in, own);
  }
  program::Totals totals;
  if (relay.tree().root()) {
    totals = program::totals(std::move(own));
  } else {
    Message message;
    program::write(own, message.bytes());
    relay.pass_up(Phase::sums, rank.session.stamp(), std::move(message), false);
    totals = read(relay.from_above(Phase::totals, rank.session.stamp()).reader(), own);
  }
  for (const roles::Tree::Range& child : relay.tree().children()) {
    Message message;
    write(totals, message.bytes());
    relay.pass_down(child, Phase::totals, rank.session.stamp(), std::move(message), false);
  }
  return totals;
}

Notes exchange_notes(Rank& rank, Note own) {
  Session& session = rank.session;
  Notes notes;
  notes.totals = std::get<std::vector<std::int64_t>>(total_of_all(rank, program::Summed(std::move(own.numbers))));
  session.relay().say(comm::Phase::notes, session.stamp(), std::as_bytes(std::span(own.text)), false);
  session.relay().hand_up(comm::Phase::notes, session.stamp());
  if (!session.manages()) return notes;
  for (const Answer& answer : session.relay().listen(comm::Phase::notes, session.stamp()).ranks) {
    notes.texts.emplace_back(reinterpret_cast<const char*>(answer.bytes.data()), answer.bytes.size());
  }
  return notes;
}

}  // namespace motes::engine
