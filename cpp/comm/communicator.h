// Messages between ranks that never block for ever: sends are posted, waits poll, name whom they wait for, and let
// an interrupt through. A message to oneself goes through a local mailbox (a blocking send to oneself hangs).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "comm/message.h"

namespace motes::comm {

/// MPI failed, or a message was not the one that the protocol has at this place.
class CommError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A rank did not answer within the stall limit.
class Stalled : public CommError {
 public:
  Stalled(int rank, const std::string& text) : CommError(text), rank_(rank) {}
  int rank() const { return rank_; }

 private:
  int rank_;
};

/// What a communicator asks of those who own it.
struct Watch {
  /// Called about every 50 ms while waiting, with the rank waited for (-1: all): may throw to end the wait.
  std::function<void(int waited_for)> while_waiting;
  /// "rank 3 (calculator 1)".
  std::function<std::string(int rank)> describe;
  /// Seconds without an answer after which a wait throws Stalled.
  double stall_s = 60;
};

/// What messages take under a simulator.
struct Weights {
  double scale = 1;    // one with particles weighs so many times its bytes: each stands for so many
  double message = 0;  // operations (see comm::execute) at each of its ends
  double byte = 0;     // and for each byte; where this is 0, what it weighs above its bytes travels behind it

  bool operator==(const Weights&) const = default;
};

/// A duplicate of the user's communicator with an error handler of its own.
class Communicator {
 public:
  /// Collective. `handle`: MPI_Comm_c2f of the user's communicator, of which MPI_Init has been called.
  Communicator(int handle, Watch watch);
  ~Communicator();
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  int rank() const;
  int size() const;

  /// Sends without waiting; the communicator keeps the message until it has left.
  /// `count`: particles in it, which the receiver holds against what it finds.
  void post(int to, Phase phase, Stamp stamp, Message message, std::uint64_t count = 0, bool failed = false);

  /// What messages take under a simulator. All ranks must say the same.
  void weigh(Weights weights);

  /// This rank will expect() a message of this phase from `from`. Under a simulator it may arrive from now on; it would
  /// set out only when waited for. Elsewhere messages do so anyway.
  void await(int from, Phase phase);

  /// Waits for the message of this phase and stamp from a rank. Throws CommError for any other, Stalled, or what
  /// Watch::while_waiting throws. `hops`: how many ranks further on may be the one that is silent; waits so much
  /// longer.
  Message expect(int from, Phase phase, Stamp stamp, int hops = 0);

  /// Waits until all posted messages have left. Collective in the sense that receivers must take part.
  void flush();

  /// Seconds spent waiting and bytes sent to other ranks so far.
  double waited_s() const;
  std::uint64_t bytes_sent() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Name and version of the MPI library in use.
std::string library_version();

}  // namespace motes::comm
