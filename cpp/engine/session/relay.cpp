#include "engine/session/relay.h"

#include <stdexcept>

namespace motes::engine {
namespace {

using base::Bytes;
using base::Reader;
using comm::Message;
using comm::Phase;
using comm::Stamp;
using Range = roles::Tree::Range;

// Layout of a message down: size and bytes of the common part, then count, size and bytes for each place of the range.
void put_common(std::span<const std::byte> common, Bytes& out) {
  out.put(static_cast<std::uint64_t>(common.size()));
  out.put_raw(common.data(), common.size());
}

void put_part(std::span<const std::byte> bytes, std::uint64_t count, Bytes& out) {
  out.put(count);
  out.put(static_cast<std::uint64_t>(bytes.size()));
  out.put_raw(bytes.data(), bytes.size());
}

ManagerMessage open(Message message) {
  ManagerMessage down;
  down.message = std::move(message);
  down.failed = down.message.header().failed != 0;
  Reader in = down.message.reader();
  down.common = in.take(in.get<std::uint64_t>());
  down.count = in.get<std::uint64_t>();
  down.own = in.take(in.get<std::uint64_t>());
  return down;
}

}  // namespace

Relay::Relay(comm::Communicator& comm, const roles::Cast& cast)
    : comm_(comm), tree_(cast, comm.size(), comm.size(), comm.rank()) {}

void Relay::grow(const roles::Cast& cast, int fan_out) {
  tree_ = roles::Tree(cast, comm_.size(), fan_out, comm_.rank());
}

void Relay::tell(Phase phase, Stamp stamp, const Bytes& common, const std::vector<RankMessage>& parts, bool failed) {
  const auto post = [&](const Range& places, int to) {
    Message message;
    std::uint64_t count = 0;
    put_common(common.view(), message.bytes());
    for (int place = places.first; place < places.end; ++place) {
      const RankMessage& part = parts[static_cast<std::size_t>(tree_.rank_at(place))];
      put_part(part.bytes.view(), part.count, message.bytes());
      count += part.count;
    }
    comm_.post(to, phase, stamp, std::move(message), count, failed);
  };
  for (const Range& child : tree_.children()) post(child, tree_.rank_at(child.first));
  post({0, 1, 0}, comm_.rank());
}

ManagerMessage Relay::hear(Phase phase, Stamp stamp) {
  ManagerMessage down = open(from_above(phase, stamp));
  if (tree_.root()) return down;
  Reader in = down.message.reader();
  in.take(in.get<std::uint64_t>());
  const auto skip = [&] {
    const auto count = in.get<std::uint64_t>();
    in.take(in.get<std::uint64_t>());
    return count;
  };
  skip();
  for (const Range& child : tree_.children()) {
    const std::span<const std::byte> all = down.message.payload();
    const std::size_t begin = all.size() - in.left();
    std::uint64_t count = 0;
    for (int place = child.first; place < child.end; ++place) count += skip();
    Message message;
    put_common(down.common, message.bytes());
    const std::span<const std::byte> parts = all.subspan(begin, all.size() - in.left() - begin);
    message.bytes().put_raw(parts.data(), parts.size());
    comm_.post(tree_.rank_at(child.first), phase, stamp, std::move(message), count, down.failed);
  }
  if (!in.done()) throw std::runtime_error("the manager's message has parts for unknown ranks");
  return down;
}

// Layout of a message up: for each place of the range, the size, whether the rank failed, and the bytes.
void Relay::say(Phase phase, Stamp stamp, std::span<const std::byte> answer, bool failed) {
  Message message;
  message.bytes().put(static_cast<std::uint64_t>(answer.size()));
  message.bytes().put(failed);
  message.bytes().put_raw(answer.data(), answer.size());
  comm_.post(tree_.leaf() ? tree_.parent() : comm_.rank(), phase, stamp, std::move(message), 0, failed);
}

void Relay::hand_up(Phase phase, Stamp stamp) {
  if (tree_.root() || tree_.leaf()) return;
  Message message = comm_.expect(comm_.rank(), phase, stamp);
  bool failed = message.header().failed != 0;
  for (const Message& below : from_below(phase, stamp)) {
    message.bytes().put_raw(below.payload().data(), below.payload().size());
    failed = failed || below.header().failed != 0;
  }
  pass_up(phase, stamp, std::move(message), failed);
}

Answers Relay::listen(Phase phase, Stamp stamp) {
  Answers all;
  all.ranks.resize(static_cast<std::size_t>(tree_.size()));
  const auto take = [&](Message message, const Range& places) {
    all.messages.push_back(std::move(message));
    Reader in = all.messages.back().reader();
    for (int place = places.first; place < places.end; ++place) {
      const auto size = in.get<std::uint64_t>();
      Answer& answer_of_rank = all.ranks[static_cast<std::size_t>(tree_.rank_at(place))];
      answer_of_rank.failed = in.get<bool>();
      answer_of_rank.bytes = in.take(size);
    }
    if (!in.done()) throw std::runtime_error("a message to the manager has answers of unknown ranks");
  };
  take(comm_.expect(comm_.rank(), phase, stamp), {0, 1, 0});
  std::vector<Message> below = from_below(phase, stamp);
  for (std::size_t c = 0; c < below.size(); ++c) take(std::move(below[c]), tree_.children()[c]);
  return all;
}

void Relay::await_below(Phase phase) {
  for (const Range& child : tree_.children()) comm_.await(tree_.rank_at(child.first), phase);
}

std::vector<Message> Relay::from_below(Phase phase, Stamp stamp) {
  await_below(phase);
  std::vector<Message> messages;
  for (const Range& child : tree_.children()) {
    messages.push_back(comm_.expect(tree_.rank_at(child.first), phase, stamp, child.height));
  }
  return messages;
}

void Relay::pass_up(Phase phase, Stamp stamp, Message message, bool failed) {
  comm_.post(tree_.parent(), phase, stamp, std::move(message), 0, failed);
}

Message Relay::from_above(Phase phase, Stamp stamp) {
  // Ranks higher in the tree allow shorter waits, so they are the first to report a silent rank.
  const int patience = tree_.height() + tree_.depth();
  return comm_.expect(tree_.parent(), phase, stamp, tree_.root() ? 0 : patience - 2);
}

void Relay::pass_down(const Range& child, Phase phase, Stamp stamp, Message message, bool failed) {
  comm_.post(tree_.rank_at(child.first), phase, stamp, std::move(message), 0, failed);
}

}  // namespace motes::engine
