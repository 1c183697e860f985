// Relays messages from the manager to all ranks, and back, along a tree. A message down has one part for all ranks and
// one for each; an answer is passed up unread. For reductions, the ranks on the way combine what comes from below and
// divide what comes from above, by calls for each step: from_below(), pass_up(), from_above(), pass_down().
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "comm/communicator.h"
#include "roles/tree.h"

namespace motes::engine {

/// The manager's message to one rank, besides the part for all.
struct RankMessage {
  base::Bytes bytes;
  std::uint64_t count = 0;  // particles in it
};

/// A message received from the manager; `message` owns the bytes.
struct Heard {
  comm::Message message;
  std::span<const std::byte> common;
  std::span<const std::byte> own;
  std::uint64_t count = 0;
  bool failed = false;
};

/// A rank's message to the manager.
struct Said {
  std::span<const std::byte> bytes;
  bool failed = false;
};

/// Messages that came up the tree, one entry per rank; `messages` own the bytes.
struct AllSaid {
  std::vector<comm::Message> messages;
  std::vector<Said> ranks;
};

class Relay {
 public:
  /// Starts without a tree: until all ranks agree on one, each talks to the manager directly.
  Relay(comm::Communicator& comm, const roles::Cast& cast);
  /// Switches to the tree of this fan-out, which is the same on all ranks.
  void grow(const roles::Cast& cast, int fan_out);
  const roles::Tree& tree() const { return tree_; }

  /// Manager: sends `common` to all ranks, and to each its part of `parts`. It calls hear() itself, too.
  void tell(comm::Phase phase, comm::Stamp stamp, const base::Bytes& common, const std::vector<RankMessage>& parts,
            bool failed);
  /// Waits for the message of tell(), and forwards the parts of the ranks below.
  Heard hear(comm::Phase phase, comm::Stamp stamp);

  /// Answers the manager; every rank calls it, the manager too. Leaves of the tree send at once, other ranks with
  /// hand_up(), together with the answers from below.
  void say(comm::Phase phase, comm::Stamp stamp, std::span<const std::byte> answer, bool failed);
  /// Waits for the answers from below, and sends them up with this rank's own. No effect on the manager and on leaves.
  void hand_up(comm::Phase phase, comm::Stamp stamp);
  /// Manager: waits for the answers of all ranks.
  AllSaid listen(comm::Phase phase, comm::Stamp stamp);

  /// Prepares to receive messages of this phase from the children.
  void await_below(comm::Phase phase);
  /// Waits for one message from each child, and returns them in the order of the children.
  std::vector<comm::Message> from_below(comm::Phase phase, comm::Stamp stamp);
  /// Sends a message to the parent, whose answer from_above() waits for. Not for the manager.
  void pass_up(comm::Phase phase, comm::Stamp stamp, comm::Message message, bool failed);
  comm::Message from_above(comm::Phase phase, comm::Stamp stamp);
  void pass_down(const roles::Tree::Range& child, comm::Phase phase, comm::Stamp stamp, comm::Message message,
                 bool failed);

 private:
  comm::Communicator& comm_;
  roles::Tree tree_;
};

}  // namespace motes::engine
