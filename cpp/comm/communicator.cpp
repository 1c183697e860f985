#include "comm/communicator.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "comm/clock.h"

namespace motes::comm {
namespace {

constexpr int kNobody = -2;  // nothing is waited for any more
constexpr int kSeveral = -1;

// Returns the factor on Watch's times for a wait. A rank may wait for one that itself waits, and the rank nearest to
// the stalled one must report first: calculators talk to each other and to the image generator before they report, and
// the manager answers only when all have reported. Each rank that relays a message adds a little.
double patience(Phase phase, int hops) {
  const double longer = 0.2 * hops;
  switch (phase) {
    case Phase::report:
    case Phase::sums:
    case Phase::notes:
    case Phase::proposals: return 1.25 + longer;
    case Phase::tiles: return 1.1 + longer;  // a tile's owner waits for records
    case Phase::begin:
    case Phase::verdict:
    case Phase::totals:
    case Phase::plan: return 1.5 + longer;
    default: return 1 + longer;
  }
}

std::string where(const Stamp& stamp, Phase phase) {
  return "frame " + std::to_string(stamp.frame) + ", phase " + name(phase);
}

void seal(Message& message, Phase phase, Stamp stamp, std::uint64_t count, bool failed, const Ledger& ledger) {
  Header header;
  header.phase = phase;
  header.failed = failed ? 1 : 0;
  header.frame = stamp.frame;
  header.turn = stamp.turn;
  header.count = static_cast<std::uint32_t>(count);
  header.set_delay(ledger.delay());
  header.set_chain_s(ledger.chain_s());
  message.set_header(header);
}

// Returns the same watch for some of its ranks, still named by their old numbers.
Watch renumbered(const Watch& old, const std::vector<int>& ranks) {
  const auto was = [ranks](int rank) { return rank < 0 ? rank : ranks.at(static_cast<std::size_t>(rank)); };
  Watch watch;
  if (old.while_waiting) watch.while_waiting = [call = old.while_waiting, was](int rank) { call(was(rank)); };
  watch.describe = [old, was](int rank) { return old.name(was(rank)); };
  if (old.life) watch.life = [call = old.life, was](int rank) { return call(was(rank)); };
  watch.warn = old.warn;
  watch.warn_s = old.warn_s;
  watch.limit_s = old.limit_s;
  return watch;
}

}  // namespace

const char* name(Phase phase) {
  constexpr const char* kNames[kPhases] = {"begin",    "report", "verdict",    "exchange",    "records", "tiles",
                                           "gather",   "plan",   "loads",      "proposals",   "births",  "log",
                                           "sums",     "totals", "all_reduce", "interaction", "notes",   "replicas",
                                           "recovery", "memory", "glow",       "shadows"};
  const auto index = static_cast<std::size_t>(phase);
  return index < kPhases ? kNames[index] : index == kPhases ? "leave" : "unknown";
}

std::size_t whole_length(std::span<const std::byte> beginning) {
  const auto header = base::Reader(beginning).get<Header>();
  if (header.magic != Header{}.magic) throw CommError("received bytes that are not a message of motes");
  return sizeof(Header) + header.payload_bytes;
}

Communicator::Communicator(std::unique_ptr<Transport> transport, Watch watch)
    : transport_(std::move(transport)), watch_(std::move(watch)) {
  wait("entering the world", 1, {}, [&] { return transport_->entered() ? kNobody : kSeveral; });
}

// Calls `pending`, which returns the awaited rank, until it returns kNobody. Counts the time as a wait for `whom`,
// unless the answer is there at once. Under a simulator the first call may itself be the wait. `pending` may set
// `delay` to what the awaited message says.
template <class Pending>
void Communicator::wait(const std::string& purpose, double times, Waited whom, const Pending& pending,
                        const Delay& delay) {
  const double start = wall_seconds();
  int for_rank = pending();
  if (for_rank == kNobody && !simulated()) return ledger_.note_messages(wall_seconds() - start);
  const double cpu = cpu_seconds();
  if (for_rank != kNobody) {
    Wait watched(watch_, rank(), purpose, times, start);
    for (int round = 0; for_rank != kNobody; ++round) {
      transport_->pause(round, watched.next_look_s());
      for_rank = pending();
      if (for_rank != kNobody) watched.look(wall_seconds(), for_rank);
    }
  }
  ledger_.note_wait(rank(), whom, start, cpu_seconds() - cpu, delay);
}

void Communicator::post(int to, Phase phase, Stamp stamp, Message message, std::uint64_t count, bool failed) {
  seal(message, phase, stamp, count, failed, ledger_);
  if (to == rank()) {
    mailbox_.push_back(std::move(message));
  } else {
    carry(to, phase, std::make_shared<const Message>(std::move(message)));
  }
}

std::shared_ptr<const Message> Communicator::sealed(Phase phase, Stamp stamp, Message message, std::uint64_t count,
                                                    bool failed) const {
  seal(message, phase, stamp, count, failed, ledger_);
  return std::make_shared<Message>(std::move(message));
}

void Communicator::post(int to, const std::shared_ptr<const Message>& message) {
  if (to == rank()) {
    mailbox_.push_back(message->copy());
  } else {
    carry(to, message->header().phase, message);
  }
}

void Communicator::carry(int to, Phase phase, std::shared_ptr<const Message> message) {
  bytes_sent_ += message->bytes().size();
  const double start = wall_seconds();
  transport_->send(to, phase, std::move(message));
  ledger_.note_messages(wall_seconds() - start);
}

void Communicator::await(int from, Phase phase, int messages) {
  if (from != rank()) transport_->await(from, phase, messages);
}

Message Communicator::expect(int from, Phase phase, Stamp stamp, int hops) {
  std::optional<Message> arrived;
  if (from != rank()) {
    Delay delay;
    const auto pending = [&] {
      if (std::optional<base::Bytes> bytes = transport_->receive(from, phase)) {
        arrived.emplace(std::move(*bytes));
        delay = arrived->header().delay();
      }
      return arrived ? kNobody : from;
    };
    wait(where(stamp, phase), patience(phase, hops), {from, from, static_cast<std::int32_t>(phase)}, pending, delay);
  }
  Message message = arrived ? std::move(*arrived) : take_own(phase);
  const Header header = message.header();
  if (from != rank()) ledger_.follow(header.chain_s());
  const bool ours = header.magic == Header{}.magic && header.phase == phase;
  if (!ours || Stamp{header.frame, header.turn} != stamp) {
    throw CommError(watch_.name(from) + " sent a message of frame " + std::to_string(header.frame) + ", turn " +
                    std::to_string(header.turn) + ", phase " + name(header.phase) + " where " + watch_.name(rank()) +
                    " expected " + where(stamp, phase) + ", turn " + std::to_string(stamp.turn));
  }
  if (header.payload_bytes != message.payload().size()) {
    throw CommError(watch_.name(from) + " sent " + std::to_string(message.payload().size()) +
                    " bytes where its header says " + std::to_string(header.payload_bytes) + ": " +
                    where(stamp, phase));
  }
  return message;
}

void Communicator::reuse(Message message) {
  const Phase phase = message.header().phase;
  transport_->reuse(phase, std::move(message.bytes()));
}

void Communicator::flush() {
  wait("delivery of its messages", 1, {}, [&] { return transport_->unsent().value_or(kNobody); });
}

void Communicator::finish() {
  flush();
  wait("end of the run", 1, {}, [&] { return transport_->finished() ? kNobody : kSeveral; });
}

Message Communicator::take_own(Phase phase) {
  const auto found =
      std::find_if(mailbox_.begin(), mailbox_.end(), [&](const Message& m) { return m.header().phase == phase; });
  if (found == mailbox_.end())
    throw CommError(watch_.name(rank()) + " waits for a message to itself that it never sent");
  Message message = std::move(*found);
  mailbox_.erase(found);
  return message;
}

std::unique_ptr<Communicator> Communicator::shrink(std::vector<int>& survivors) {
  revoke();
  std::unique_ptr<Transport> among;
  wait("agreement on the remaining ranks", 1, {}, [&] {
    among = transport_->shrink(survivors);
    return among ? kNobody : kSeveral;
  });
  auto made = std::make_unique<Communicator>(std::move(among), renumbered(watch_, survivors));
  made->ledger_ = std::move(ledger_);
  made->ledger_.on_wait({});  // the listener belongs to the old connections
  made->bytes_sent_ += bytes_sent_;
  return made;
}

}  // namespace motes::comm
