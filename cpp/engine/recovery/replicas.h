// Replicas in memory, against the loss of ranks. Every few frames each calculator keeps its own particles and a replica
// of its neighbour's; all ranks keep what they know of the world and the lists of the frames since:
//
//   calculator 0: own 0, replica of n-1    calculator 1: own 1, replica of 0    ...
//
// From these recover.cpp restores the world, unless a calculator is lost together with the holder of its replica.
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
  int calculator = -1;  // whose particles; -1: none
  std::shared_ptr<const comm::Message> message;
};

/// A generation as one rank holds it.
struct Generation {
  GenerationId of;
  std::uint32_t parts = 0;  // calculators then; 0: there were no particles yet
  std::size_t systems = 0;
  base::Bytes state;  // SharedState
  Replica own, other;  // own particles, and the replica that the neighbour sent
  bool arrived = false;  // `other` is here, if one comes
  bool counts = false;  // the world may be made again from it
};

/// The list of a frame that has run.
struct KeptList {
  std::uint64_t frame = 0;
  base::Bytes record;
  bool needs_script = false;  // calls functions of the script, or the script wrote to particles
};

class Replicas {
 public:
  /// Copies are made before each frame whose number is a multiple of `every`, which is at least kLag + 2.
  void begin(const Parts& parts, std::uint64_t every);
  bool on() const { return every_ > 0; }

  /// The frame under way has this list.
  void note_list(std::uint64_t frame, const base::Bytes& record, bool needs_script);
  /// Collective, between two frames: sends and takes what is due, and forgets what is no longer needed. `unsaved_from`:
  /// the first frame whose picture may have to be made again.
  void at_border(Parts& parts, std::uint64_t unsaved_from);
  /// Collective: takes what is under way, which its sender must be rid of before the end.
  void take_rest(Rank& rank);
  /// Collective: makes a generation here and now, in place of all earlier ones where `alone` says so. `wait`: until
  /// this rank has what is sent to it.
  void make(Parts& parts, bool alone, bool wait);

  const std::deque<Generation>& generations() const { return generations_; }
  const Generation* find(GenerationId of) const;
  const std::deque<KeptList>& lists() const { return lists_; }
  /// The world is made again from this generation: those behind it are of frames that have not run.
  void forget_behind(GenerationId of);
  /// How often ranks were lost so far.
  std::uint32_t losses = 0;
  /// Frames from this one on have not run: their lists are noted again.
  void forget_lists_from(std::uint64_t frame);

 private:
  void take(Rank& rank, Generation& generation);
  void forget(Rank& rank, std::uint64_t unsaved_from, std::uint64_t now);
  base::Bytes spare();

  std::uint64_t every_ = 0;
  std::deque<Generation> generations_;  // the oldest first
  std::deque<KeptList> lists_;  // without gaps, from the oldest generation on
  std::vector<std::shared_ptr<const comm::Message>> used_;  // none of them const: their memory may be used again
};

/// The content of a replica message.
struct OpenedReplica {
  snapshots::Description description;
  std::span<const std::byte> planes;
};
OpenedReplica open(const Replica& replica);

}  // namespace motes::engine
