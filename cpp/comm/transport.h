// The interface below the conversations: how bytes travel between ranks. Implemented by MPI (mpi/transport.cpp), by
// SimGrid's simulated MPI (mpi/smpi_transport.cpp) and by ranks that are threads of one process (simulated_ranks.h).
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "comm/errors.h"
#include "comm/message.h"

namespace motes::comm {

/// The cost of messages under a simulator.
struct Weights {
  double scale = 1;    // factor on the size of messages with particles: each particle stands for this many
  double message = 0;  // operations (see comm::execute) per message at each end
  double byte = 0;     // operations per byte at each end; if 0, SimGrid sends the extra size behind the message

  bool operator==(const Weights&) const = default;
};

/// One rank's end of all connections. No call throws because another rank is late: it answers "not yet", and the caller
/// calls pause() and asks again. A simulator's transport may return only when the answer is yes.
///
/// Messages in flight when a wait is given up outlive the transport: their memory stays valid.
///
/// Where losses are survived, calls that wait for a lost rank throw RankLost soon, but not at the same moment on all
/// ranks. Ranks that wait for other ranks learn of the loss only by revoke(). Once an end has thrown RankLost, all its
/// calls do; the surviving ranks continue with shrink().
class Transport {
 public:
  Transport() = default;
  virtual ~Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Collective. Tells whether all ranks have called this. Must come before all calls below.
  virtual bool entered() = 0;

  /// Sends without waiting; keeps the message until it has left. Messages of one phase from one rank to another stay in
  /// order. Never to oneself.
  virtual void send(int to, Phase phase, std::shared_ptr<const Message> message) = 0;

  /// Announces that this rank will receive `messages` messages of this phase from `from`, so they may arrive from now
  /// on. Announcements do not add up.
  virtual void await(int from, Phase phase, int messages) = 0;

  /// Moves messages that are in flight or awaited while this rank computes, since MPI may move nothing between two of
  /// its calls. Returns at once, and costs nothing if there is nothing to do.
  virtual void progress() noexcept {}

  /// Returns the next message of this phase from a rank, if all of it has arrived.
  virtual std::optional<base::Bytes> receive(int from, Phase phase) = 0;

  /// Returns a rank that has not taken a message yet, or nothing if all messages have left.
  virtual std::optional<int> unsent() = 0;

  /// Collective. Tells whether all ranks have called this. All messages must have left; nothing may be sent afterwards.
  /// Where losses are survived, all surviving ranks get the same answer: true, or RankLost.
  virtual bool finished() = 0;

  /// Waits briefly for what the last call asked. `round`: number of earlier pauses in this wait; `until_s`: the time
  /// (comm::wall_seconds) at which the caller wants control back.
  virtual void pause(int round, double until_s) = 0;

  virtual void weigh(Weights) {}

  /// Offers memory for a later message of this phase that arrives here: fresh memory costs more than copying into it.
  virtual void reuse(Phase, base::Bytes) {}

  /// Returns whether ranks are processes. Simulated ranks must not reach each other's memory.
  virtual bool between_processes() const { return false; }

  /// Returns whether the other ranks can continue when a rank is lost.
  virtual bool survives() const { return false; }

  /// Makes every later call on any rank's end throw RankLost, except shrink(), so no rank waits for one that recovers.
  /// Not collective; may be called more than once.
  virtual void revoke() { throw CommError("these connections do not survive the loss of a rank"); }

  /// Collective among the surviving ranks, after revoke(). Returns connections among them, in their order and already
  /// entered; null until all of them have called this: then call pause() and ask again. `survivors`: the old rank of
  /// each. A rank that dies meanwhile is left out, or calls on the new connections throw RankLost. Throws CommError if
  /// all ranks have finished() meanwhile.
  virtual std::unique_ptr<Transport> shrink(std::vector<int>& survivors) {
    survivors.clear();
    throw CommError("these connections do not survive the loss of a rank");
  }

  /// Returns the handle of the communicator (MPI_Comm_c2f), for other messages among the same ranks; -1 without MPI.
  virtual int handle() const { return -1; }
};

}  // namespace motes::comm
