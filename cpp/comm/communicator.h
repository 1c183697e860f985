// Messages between ranks that never block forever: sends are posted; waits name the awaited rank and can be
// interrupted. A message to oneself goes through a local mailbox (a blocking send to oneself hangs).
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "comm/errors.h"
#include "comm/ledger.h"
#include "comm/message.h"
#include "comm/transport.h"
#include "comm/wait.h"

namespace motes::comm {

/// The layer between the engine's conversations and a transport: headers, stamps, checks and time limits.
class Communicator {
 public:
  /// Collective. Waits until all ranks have made their communicators.
  Communicator(std::unique_ptr<Transport> transport, Watch watch);
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  int rank() const { return transport_->rank(); }
  int size() const { return transport_->size(); }

  /// Sends without waiting; the message is kept until it has left. `count`: particles in the message, for the receiver
  /// to check.
  void post(int to, Phase phase, Stamp stamp, Message message, std::uint64_t count = 0, bool failed = false);

  /// Post a message in two steps, without a copy: for one that goes to several ranks or that the sender keeps.
  std::shared_ptr<const Message> sealed(Phase phase, Stamp stamp, Message message, std::uint64_t count = 0,
                                        bool failed = false) const;
  void post(int to, const std::shared_ptr<const Message>& message);

  /// Sets the cost of messages under a simulator. All ranks must set the same.
  void weigh(Weights weights) { transport_->weigh(weights); }

  /// Announces that this rank will expect() `messages` messages of this phase from `from`, so they may arrive from now
  /// on. Announcements do not add up. Without it, a message under SimGrid, or a large one that MPI moves only with both
  /// ends, would start only when waited for.
  void await(int from, Phase phase, int messages = 1);

  /// Moves messages; call it now and then while this rank computes. Never throws and never waits.
  void progress() noexcept { transport_->progress(); }

  /// Waits for the message of this phase and stamp from a rank. Throws CommError for any other message, Stalled after
  /// too long a wait, or what Watch::while_waiting throws. `hops`: how many ranks further on a silent rank may be; more
  /// hops allow a longer wait.
  Message expect(int from, Phase phase, Stamp stamp, int hops = 0);

  /// Gives the memory of a message that is no longer needed to a later one of its phase that arrives here.
  void reuse(Message message);

  /// Waits until all posted messages have left, for which their receivers must take part.
  void flush();

  /// Collective. Ends all conversations: waits until all messages have left and all ranks have called this, then frees
  /// what the transport holds. A communicator that is destroyed without it (the run failed) leaves that to
  /// MPI_Finalize, since the other ranks may not be there to agree.
  void finish();

  /// Returns whether ranks are processes, which can share memory on one host. The same on all ranks.
  bool between_processes() const { return transport_->between_processes(); }

  /// Returns whether the other ranks can continue when a rank is lost. If so, any call may throw RankLost, and later
  /// calls then do so, too (see Transport).
  bool survives() const { return transport_->survives(); }

  /// Makes every rank's calls throw RankLost, so no rank waits for one that recovers. Not collective.
  void revoke() { transport_->revoke(); }

  /// Collective among the surviving ranks, after RankLost. Returns a communicator of them, in the order of their ranks.
  /// `survivors`: the old rank of each. The new communicator continues the counts of seconds and bytes, and its Watch
  /// uses the old rank numbers until set_watch(). Waits with this one's Watch; throws as any wait does.
  std::unique_ptr<Communicator> shrink(std::vector<int>& survivors);

  const Watch& watch() const { return watch_; }
  void set_watch(Watch watch) { watch_ = std::move(watch); }

  /// Returns the handle of the communicator (MPI_Comm_c2f), for other messages among the same ranks; -1 without MPI.
  int handle() const { return transport_->handle(); }

  /// Return the seconds spent waiting, and the bytes sent to other ranks, so far.
  double waited_s() const { return ledger_.waited_s(); }
  std::uint64_t bytes_sent() const { return bytes_sent_; }

  /// Returns the account of this rank's time.
  Ledger& ledger() { return ledger_; }

 private:
  template <class Pending>
  void wait(const std::string& purpose, double times, Waited whom, const Pending& pending, const Delay& delay = {});
  void carry(int to, Phase phase, std::shared_ptr<const Message> message);
  Message take_own(Phase phase);

  std::unique_ptr<Transport> transport_;
  Watch watch_;
  std::deque<Message> mailbox_;  // messages to oneself
  Ledger ledger_;
  std::uint64_t bytes_sent_ = 0;
};

}  // namespace motes::comm
