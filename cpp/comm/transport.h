// The seam under the conversations: how bytes travel between ranks. Implemented by MPI (mpi_transport.cpp), by
// SimGrid's simulated MPI (smpi_transport.cpp) and by ranks that are threads of one process (simulated_ranks.h).
#pragma once

#include <optional>

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
  virtual void send(int to, Phase phase, Message message) = 0;

  /// This rank will receive a message of this phase from `from`. Only a simulator needs to know in advance.
  virtual void await(int from, Phase phase) = 0;

  /// The next message of this phase from a rank, if all of it has arrived.
  virtual std::optional<particles::Bytes> receive(int from, Phase phase) = 0;

  /// A rank that has not taken a message yet, or nothing if all messages have left.
  virtual std::optional<int> unsent() = 0;

  /// Whether all ranks have come to the end. Collective: all messages must have left. Nothing may be sent afterwards.
  virtual bool finished() = 0;

  /// Waits a little for what the last question was about. `round`: how many pauses came before this one in the wait;
  /// `until_s`: the time (comm::wall_seconds) at which the caller wants to look around.
  virtual void pause(int round, double until_s) = 0;

  virtual void weigh(Weights) {}
};

}  // namespace motes::comm
