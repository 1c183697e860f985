#include "engine/recovery/replicas.h"

#include <algorithm>
#include <utility>

#include "base/fields.h"
#include "engine/parts/snapshot.h"

namespace motes::engine {
namespace {

using comm::Phase;

// The number of frames after which a generation is received and becomes valid; one frame later, all ranks have it. This
// gives replicas time to travel. By then the log has the rows of all frames before the generation, because the manager
// writes them before it takes part in the next frame.
constexpr std::uint64_t kLag = 2;

// Returns the calculator that holds the replica of this one's particles.
int holder_of(const Session& session, int calculator) {
  const int count = static_cast<int>(session.calculators());
  if (count > 1) return session.rank_of((calculator + 1) % count);
  return (session.rank_of(calculator) + 1) % session.size();
}

// Returns the calculator whose replica this rank holds; -1: none.
int held_by(const Session& session) {
  const int count = static_cast<int>(session.calculators());
  if (session.size() == 1) return -1;
  if (count == 1) return holder_of(session, 0) == session.rank() ? 0 : -1;
  return session.calculates() ? (session.calculator() + count - 1) % count : -1;
}

comm::Stamp stamp(const GenerationId& of) { return {of.frame, of.losses}; }

}  // namespace

OpenedReplica open(const Replica& replica) {
  const std::span<const std::byte> payload = replica.message->payload();
  const std::size_t length = sizeof(std::uint64_t);
  const auto description = base::Reader(payload.last(length)).get<std::uint64_t>();
  OpenedReplica opened;
  opened.planes = payload.first(payload.size() - length - description);
  base::Reader in(payload.subspan(opened.planes.size(), description));
  base::read_fields(in, opened.description);
  return opened;
}

void Replicas::begin(const Parts& parts, std::uint64_t every) {
  every_ = std::max(every, kLag + 2);
  Generation none;  // before the first frame there are no particles
  none.of.frame = parts.rank.session.frame;
  none.systems = parts.script.systems.size();
  base::write_fields(shared_state(parts), none.state);
  none.arrived = none.counts = true;
  generations_.push_back(std::move(none));
}

const Generation* Replicas::find(GenerationId of) const {
  const auto generation =
      std::find_if(generations_.begin(), generations_.end(), [&](const Generation& g) { return g.of == of; });
  return generation == generations_.end() ? nullptr : &*generation;
}

void Replicas::note_list(std::uint64_t frame, const base::Bytes& record, bool needs_script) {
  forget_lists_from(frame);
  KeptList list{frame, {}, needs_script};
  list.record.put_raw(record.data(), record.size());
  lists_.push_back(std::move(list));
}

void Replicas::forget_lists_from(std::uint64_t frame) {
  while (!lists_.empty() && lists_.back().frame >= frame) lists_.pop_back();
}

void Replicas::forget_behind(GenerationId of) {
  while (generations_.back().of > of) generations_.pop_back();
  for (Generation& generation : generations_) generation.arrived = true;  // pending replicas will not arrive
}

void Replicas::at_border(Parts& parts, std::uint64_t unsaved_from) {
  Rank& rank = parts.rank;
  const std::uint64_t now = rank.session.frame;
  for (Generation& generation : generations_) {
    if (generation.counts || generation.of.frame + kLag > now) continue;
    if (!generation.arrived) take(rank, generation);
    generation.counts = true;
  }
  forget(rank, unsaved_from, now);
  if (now % every_ == 0) make(parts, false, false);
}

void Replicas::make(Parts& parts, bool alone, bool wait) {
  if (alone) {
    generations_.clear();
    lists_.clear();
  }
  Rank& rank = parts.rank;
  Session& session = rank.session;
  Generation generation;
  generation.of = {session.frame, losses};
  generation.parts = static_cast<std::uint32_t>(session.calculators());
  generation.systems = parts.script.systems.size();
  generation.border = rank.watch.ledger().border();
  base::write_fields(shared_state(parts), generation.state);
  if (session.calculates()) {
    comm::Message message;
    message.bytes() = spare();
    message.bytes().put(comm::Header{});
    base::Bytes& bytes = message.bytes();
    const snapshots::Description description = copy_part(rank, parts.script, parts.calculator, bytes);
    const std::size_t before = bytes.size();
    base::write_fields(description, bytes);
    bytes.put(static_cast<std::uint64_t>(bytes.size() - before));
    std::uint64_t count = 0;
    for (const snapshots::SavedSystem& system : description.systems) count += system.rows;
    generation.own = {session.calculator(),
                      session.comm().sealed(Phase::replicas, stamp(generation.of), std::move(message), count)};
    const int holder = holder_of(session, session.calculator());
    if (holder != session.rank()) session.comm().post(holder, generation.own.message);
  }
  generation.other.calculator = held_by(session);
  generation.arrived = generation.other.calculator < 0;
  if (wait && !generation.arrived) take(rank, generation);
  generation.counts = wait;  // valid at once: the log ends here
  generations_.push_back(std::move(generation));
}

void Replicas::take_rest(Rank& rank) {
  for (Generation& generation : generations_) {
    if (!generation.arrived) take(rank, generation);
  }
}

void Replicas::take(Rank& rank, Generation& generation) {
  Session& session = rank.session;
  const int from = session.rank_of(generation.other.calculator);
  generation.other.message =
      std::make_shared<comm::Message>(session.comm().expect(from, Phase::replicas, stamp(generation.of)));
  generation.arrived = true;
}

// Forgets the generations before the newest one that all ranks have, except one that pictures may need: the newest at
// or before `unsaved_from`.
void Replicas::forget(Rank& rank, std::uint64_t unsaved_from, std::uint64_t now) {
  std::optional<std::size_t> whole, wanted;
  for (std::size_t i = 0; i < generations_.size(); ++i) {
    if (generations_[i].of.frame + kLag >= now && generations_[i].of.frame > 0) continue;
    whole = i;
    if (generations_[i].of.frame <= unsaved_from) wanted = i;
  }
  if (!whole) return;
  std::deque<Generation> remaining;
  used_.clear();
  for (std::size_t i = 0; i < generations_.size(); ++i) {
    Generation& generation = generations_[i];
    if (i >= *whole || i == wanted || (!wanted && i == 0)) {
      remaining.push_back(std::move(generation));
    } else {
      used_.push_back(std::move(generation.own.message));
      if (const auto other = std::move(generation.other.message); other && other.use_count() == 1) {
        rank.session.comm().reuse(std::move(*std::const_pointer_cast<comm::Message>(other)));
      }
    }
  }
  generations_ = std::move(remaining);
  while (!lists_.empty() && lists_.front().frame < generations_.front().of.frame) lists_.pop_front();
}

// Returns the memory of a message that is no longer used: allocating new memory costs more than copying into it.
base::Bytes Replicas::spare() {
  for (const std::shared_ptr<const comm::Message>& message : used_) {
    if (!message || message.use_count() > 1) continue;
    base::Bytes bytes = std::move(std::const_pointer_cast<comm::Message>(message)->bytes());
    used_.clear();
    bytes.clear();
    return bytes;
  }
  return {};
}

}  // namespace motes::engine
