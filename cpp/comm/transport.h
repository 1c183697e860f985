// The seam under the conversations: how bytes travel between ranks. Implemented by MPI (mpi_transport.cpp), by
// SimGrid's simulated MPI (smpi_transport.cpp) and by ranks that are threads of one process (simulated_ranks.h).
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "comm/errors.h"
#include "comm/message.h"

namespace motes::comm {

/// What messages take under a simulator.
struct Weights {
  double scale = 1;    // a message with particles weighs this many times its bytes: each particle stands for so many
  double message = 0;  // operations (see comm::execute) at each of its ends
  double byte = 0;     // and for each byte; where this is 0, SimGrid sends the extra weight behind the message

  bool operator==(const Weights&) const = default;
};

/// One rank's end of all connections. Nothing here throws because another rank is late: the questions answer "not yet",
/// and the caller calls pause() and asks again. Transports of simulators may answer a question only when it is time.
///
/// What is under way when a wait is given up outlives the transport: its memory stays valid.
///
/// Where losses are survived, what waits for a lost rank throws RankLost, soon but not at the same moment on all ranks;
/// those that wait for others learn of it by revoke() alone. An end that has thrown RankLost once throws nothing else:
/// who is left goes on by shrink().
class Transport {
 public:
  Transport() = default;
  virtual ~Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Whether all ranks have come to this place. Collective: comes before everything below.
  virtual bool entered() = 0;

  /// Sends without waiting; keeps the message until it has left. Messages of one phase from one rank to another stay in
  /// order. Never to oneself.
  virtual void send(int to, Phase phase, std::shared_ptr<const Message> message) = 0;

  /// This rank will receive so many messages of this phase from `from`, whatever it said before: they may arrive from
  /// now on.
  virtual void await(int from, Phase phase, int messages) = 0;

  /// Lets messages travel that are under way, or awaited, while this rank computes. MPI may move nothing between two
  /// calls of it. Returns at once, and costs nothing where there is nothing to do.
  virtual void progress() noexcept {}

  /// The next message of this phase from a rank, if all of it has arrived.
  virtual std::optional<base::Bytes> receive(int from, Phase phase) = 0;

  /// A rank that has not taken a message yet, or nothing if all messages have left.
  virtual std::optional<int> unsent() = 0;

  /// Whether all ranks have come to the end. Collective: all messages must have left. Nothing may be sent afterwards.
  /// Where losses are survived, all that live come to the same answer: true on all, or RankLost on all.
  virtual bool finished() = 0;

  /// Waits a little for what the last question was about. `round`: how many pauses came before this one in the wait;
  /// `until_s`: the time (comm::wall_seconds) at which the caller wants to look around.
  virtual void pause(int round, double until_s) = 0;

  virtual void weigh(Weights) {}

  /// Memory for a later message of this phase that arrives here: fresh memory costs more than what is copied into it.
  virtual void reuse(Phase, base::Bytes) {}

  /// Whether ranks are processes: of simulated ones none may reach the other's memory.
  virtual bool between_processes() const { return false; }

  /// Whether those that are left can go on when a rank is lost.
  virtual bool survives() const { return false; }

  /// From now on every call on any rank's end throws RankLost, apart from shrink(): nobody waits for one that recovers.
  /// Not collective; may be called more than once.
  virtual void revoke() { throw CommError("these connections do not survive the loss of a rank"); }

  /// Connections among the ranks that live, in their order, when all of them have come here; null before: call pause()
  /// and ask again. They have been entered already. Collective among those that live, after revoke(). `survivors`: the
  /// old rank of each. Who dies meanwhile is left out, or calls on the new connections throw RankLost. Throws CommError
  /// where all ranks have finished() meanwhile.
  virtual std::unique_ptr<Transport> shrink(std::vector<int>& survivors) {
    survivors.clear();
    throw CommError("these connections do not survive the loss of a rank");
  }

  /// What MPI_Comm_f2c takes, for messages beside these; -1 without MPI.
  virtual int handle() const { return -1; }
};

}  // namespace motes::comm
