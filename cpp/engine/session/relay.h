// Messages from the manager to all ranks and back, relayed along a tree. What goes down has a part for all ranks and a
// part for each; what comes up is each rank's own answer, which no rank on the way reads. Or ranks on the way put
// together what comes up, and divide what goes down: that is theirs to do, step by step.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "comm/communicator.h"
#include "roles/tree.h"

namespace motes::engine {

/// The manager's message to one rank, besides the part for all.
struct Part {
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
  /// Until grow() all ranks talk to the manager directly: they have not yet agreed on a tree.
  Relay(comm::Communicator& comm, const roles::Cast& cast);
  /// Switches to this tree, on which all ranks have agreed.
  void grow(const roles::Cast& cast, int fan_out);
  const roles::Tree& tree() const { return tree_; }

  /// Manager: sends `common` to all ranks, and to each its part of `parts`. This rank hears them like any other.
  void tell(comm::Phase phase, comm::Stamp stamp, const base::Bytes& common, const std::vector<Part>& parts,
            bool failed);
  /// Waits for what tell() sent, and passes on what is for those below.
  Heard hear(comm::Phase phase, comm::Stamp stamp);

  /// Every rank, the manager too: its answer to the manager. It leaves at once if no rank stands below this one in the
  /// tree, otherwise with hand_up().
  void say(comm::Phase phase, comm::Stamp stamp, std::span<const std::byte> answer, bool failed);
  /// Waits for the answers from below, and relays them with this rank's own. Does nothing on the manager and on leaves.
  void hand_up(comm::Phase phase, comm::Stamp stamp);
  /// Manager: waits for all.
  AllSaid listen(comm::Phase phase, comm::Stamp stamp);

  /// Messages of this phase may arrive from below from now on.
  void await_below(comm::Phase phase);
  /// Waits for what each child sent up, in their order.
  std::vector<comm::Message> from_below(comm::Phase phase, comm::Stamp stamp);
  /// Sends a message to the rank above; from_above() waits for its answer. Not for the manager.
  void pass_up(comm::Phase phase, comm::Stamp stamp, comm::Message message, bool failed);
  comm::Message from_above(comm::Phase phase, comm::Stamp stamp);
  void pass_down(const roles::Tree::Range& child, comm::Phase phase, comm::Stamp stamp, comm::Message message,
                 bool failed);

 private:
  comm::Communicator& comm_;
  roles::Tree tree_;
};

}  // namespace motes::engine
