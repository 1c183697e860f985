// In-memory replicas, to survive the loss of ranks. Every few frames each calculator copies its own particles and gets
// a replica of its neighbour's; all ranks keep the shared state and the lists of the frames since:
//
//   calculator 0: own 0, replica of n-1    calculator 1: own 1, replica of 0    ...
//
// recovering_engine.cpp restores the world from these, unless a calculator is lost together with the holder of its
// replica.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "comm/message.h"
#include "engine/parts/parts.h"
#include "snapshots/part.h"

namespace motes::engine {

/// Identifies a generation of replicas: made before `frame`, after `losses` losses.
struct GenerationId {
  std::uint64_t frame = 0;
  std::uint32_t losses = 0;

  auto operator<=>(const GenerationId&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, GenerationId& of) {
  visit(of.frame, of.losses);
}

/// A calculator's particles as a message.
struct Replica {
  int calculator = -1;  // owner of the particles; -1: none
  std::shared_ptr<const comm::Message> message;
};

/// One rank's part of a generation.
struct Generation {
  GenerationId of;
  std::uint32_t parts = 0;  // number of calculators; 0: there were no particles yet
  std::size_t systems = 0;
  base::Bytes state;  // SharedState
  comm::Border border;  // of this rank's time
  Replica own, other;  // this rank's particles, and the replica of a neighbour's
  bool arrived = false;  // `other` has arrived, or none is expected
  bool counts = false;  // the world may be restored from it
};

/// The list of a frame that has run.
struct KeptList {
  std::uint64_t frame = 0;
  base::Bytes record;
  bool needs_script = false;  // calls functions of the script, or the script wrote to particles
};

class Replicas {
 public:
  /// Starts keeping replicas, made before each frame whose number is a multiple of `every`, which is at least kLag + 2.
  void begin(const Parts& parts, std::uint64_t every);
  bool on() const { return every_ > 0; }

  /// Keeps the list of the current frame.
  void note_list(std::uint64_t frame, const base::Bytes& record, bool needs_script);
  /// Sends and receives the replicas that are due, and forgets those no longer needed. `unsaved_from`: the first frame
  /// whose picture may be needed again. Collective, between two frames.
  void at_border(Parts& parts, std::uint64_t unsaved_from);
  /// Receives all pending replicas, so their senders can finish. Collective.
  void take_rest(Rank& rank);
  /// Makes a generation now. `alone`: it replaces all earlier ones. `wait`: wait until this rank has received its
  /// replica. Collective.
  void make(Parts& parts, bool alone, bool wait);

  const std::deque<Generation>& generations() const { return generations_; }
  const Generation* find(GenerationId of) const;
  const std::deque<KeptList>& lists() const { return lists_; }
  /// Forgets the generations after this one, from which the world is restored.
  void forget_behind(GenerationId of);
  /// Number of losses of ranks so far.
  std::uint32_t losses = 0;
  /// Forgets the lists from this frame on, which will be noted again.
  void forget_lists_from(std::uint64_t frame);

 private:
  void take(Rank& rank, Generation& generation);
  void forget(Rank& rank, std::uint64_t unsaved_from, std::uint64_t now);
  base::Bytes spare();

  std::uint64_t every_ = 0;
  std::deque<Generation> generations_;  // the oldest first
  std::deque<KeptList> lists_;  // of consecutive frames, from the oldest generation on
  std::vector<std::shared_ptr<const comm::Message>> used_;  // created non-const: their memory may be reused
};

/// The content of a replica message.
struct OpenedReplica {
  snapshots::Description description;
  std::span<const std::byte> planes;
};
OpenedReplica open(const Replica& replica);

}  // namespace motes::engine
