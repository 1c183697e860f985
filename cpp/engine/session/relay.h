// Relays messages from the manager to all ranks, and back, along a tree (roles/tree.h), so that no rank talks to more
// than a few others. Seven ranks by their places in a tree of fan-out 2:
//
//       .---- 0 ----.        the manager
//     .-1-.       .-4-.      ranks in between
//     2   3       5   6      leaves
//
// A message down has a part for all ranks (c) and a part for each rank. tell() sends it; hear() returns this rank's
// parts and forwards those of the places below:
//
//   0 -- c 1 2 3 --> 1 -- c 2 --> 2        0 -- c 4 5 6 --> 4 -- c 5 --> 5
//                    1 -- c 3 --> 3                         4 -- c 6 --> 6
//
// Answers come up unread. Leaves send theirs in say(), ranks in between add theirs in hand_up(), and listen() returns
// all of them to the manager:
//
//   2 -- 2 --> 1 -- 1 2 3 --> 0            5 -- 5 --> 4 -- 4 5 6 --> 0
//   3 -- 3 --> 1                           6 -- 6 --> 4
//
// In a reduction the ranks in between read messages: they combine what comes up and split what comes down, with one
// call per step. The agreement of a round (agree.h) is one:
//
//   report     each rank: from_below(), merge with its own (reports.h), pass_up()
//   judgement  the manager: from the merged report of all ranks to the verdict, who gets migrants, who gets children
//   verdict    each rank: from_above(), keep its part, pass_down() to each child what concerns the places below
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "comm/communicator.h"
#include "roles/tree.h"

namespace motes::engine {

/// The part of the manager's message that is for one rank only.
struct RankMessage {
  base::Bytes bytes;
  std::uint64_t count = 0;  // number of particles in it
};

/// A message received from the manager; `message` owns the bytes.
struct ManagerMessage {
  comm::Message message;
  std::span<const std::byte> common;
  std::span<const std::byte> own;
  std::uint64_t count = 0;
  bool failed = false;
};

/// A rank's message to the manager.
struct Answer {
  std::span<const std::byte> bytes;
  bool failed = false;
};

/// Messages that came up the tree, one entry per rank; `messages` own the bytes.
struct Answers {
  std::vector<comm::Message> messages;
  std::vector<Answer> ranks;
};

class Relay {
 public:
  /// Starts without a tree: until all ranks agree on one, each communicates with the manager directly.
  Relay(comm::Communicator& comm, const roles::Cast& cast);
  /// Switches to the tree of this fan-out, which is the same on all ranks.
  void grow(const roles::Cast& cast, int fan_out);
  const roles::Tree& tree() const { return tree_; }

  /// Manager: sends `common` to all ranks and to each its part. The manager then calls hear() as well.
  void tell(comm::Phase phase, comm::Stamp stamp, const base::Bytes& common, const std::vector<RankMessage>& parts,
            bool failed);
  /// Waits for the message of tell(), forwards the parts of the ranks below and returns this rank's.
  ManagerMessage hear(comm::Phase phase, comm::Stamp stamp);

  /// Answers the manager; every rank calls it, including the manager. Leaves of the tree send at once; other ranks send
  /// with hand_up(), together with the answers from below.
  void say(comm::Phase phase, comm::Stamp stamp, std::span<const std::byte> answer, bool failed);
  /// Waits for the answers from below, and sends them up with this rank's. No effect on the manager and on leaves.
  void hand_up(comm::Phase phase, comm::Stamp stamp);
  /// Manager: waits for the answers of all ranks.
  Answers listen(comm::Phase phase, comm::Stamp stamp);

  /// Prepares to receive messages of this phase from the children.
  void await_below(comm::Phase phase);
  /// Waits for one message from each child, and returns them in the order of the children.
  std::vector<comm::Message> from_below(comm::Phase phase, comm::Stamp stamp);
  /// Sends a message to the parent; from_above() waits for its answer. Not for the manager.
  void pass_up(comm::Phase phase, comm::Stamp stamp, comm::Message message, bool failed);
  comm::Message from_above(comm::Phase phase, comm::Stamp stamp);
  void pass_down(const roles::Tree::Range& child, comm::Phase phase, comm::Stamp stamp, comm::Message message,
                 bool failed);

 private:
  comm::Communicator& comm_;
  roles::Tree tree_;
};

}  // namespace motes::engine
