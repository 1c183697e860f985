// Messages between ranks that never block for ever: sends are posted; waits name the rank waited for, and let an
// interrupt through. A message to oneself goes through a local mailbox (a blocking send to oneself hangs).
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "comm/errors.h"
#include "comm/message.h"
#include "comm/transport.h"
#include "comm/wait.h"

namespace motes::comm {

/// What the engine's conversations go through, whatever carries the bytes: headers, stamps, checks and patience.
class Communicator {
 public:
  /// Collective. Waits until all ranks have made theirs.
  Communicator(std::unique_ptr<Transport> transport, Watch watch);
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  int rank() const { return transport_->rank(); }
  int size() const { return transport_->size(); }

  /// Sends without waiting; the message is kept until it has left.
  /// `count`: particles in it, which the receiver holds against what it finds.
  void post(int to, Phase phase, Stamp stamp, Message message, std::uint64_t count = 0, bool failed = false);

  /// What messages take under a simulator. All ranks must say the same.
  void weigh(Weights weights) { transport_->weigh(weights); }

  /// This rank will expect() a message of this phase from `from`. Under SimGrid it may arrive from now on; it would set
  /// out only when waited for. Elsewhere messages do so anyway.
  void await(int from, Phase phase);

  /// Waits for the message of this phase and stamp from a rank. Throws CommError for any other, Stalled, or what
  /// Watch::while_waiting throws. `hops`: how many ranks further on the silent one may be; waits so much longer.
  Message expect(int from, Phase phase, Stamp stamp, int hops = 0);

  /// Waits until all posted messages have left: their receivers must take part.
  void flush();

  /// Collective: the end of all conversations. Waits until all messages have left and all ranks are here, and gives
  /// back what the transport holds. A communicator that is destroyed without it (the run failed) leaves that to MPI's
  /// own end, since the other ranks may not be there to agree.
  void finish();

  /// Seconds spent waiting and bytes sent to other ranks so far.
  double waited_s() const { return waited_s_; }
  std::uint64_t bytes_sent() const { return bytes_sent_; }

 private:
  template <class Pending>
  void wait(const std::string& purpose, double limits, const Pending& pending);
  Message take_own(Phase phase);

  std::unique_ptr<Transport> transport_;
  Watch watch_;
  std::deque<Message> mailbox_;  // to oneself
  double waited_s_ = 0;
  std::uint64_t bytes_sent_ = 0;
};

}  // namespace motes::comm
