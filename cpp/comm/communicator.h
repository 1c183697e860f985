// Messages between ranks that never block for ever: sends are posted; waits name the rank waited for, and let an
// interrupt through. A message to oneself goes through a local mailbox (a blocking send to oneself hangs).
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

  /// The same in two steps, for a message that goes to several ranks or that the sender keeps: no copy is made of it.
  std::shared_ptr<const Message> sealed(Phase phase, Stamp stamp, Message message, std::uint64_t count = 0,
                                        bool failed = false) const;
  void post(int to, const std::shared_ptr<const Message>& message);

  /// What messages take under a simulator. All ranks must say the same.
  void weigh(Weights weights) { transport_->weigh(weights); }

  /// This rank will expect() so many messages of this phase from `from`, whatever it said before: they may arrive from
  /// now on. Under SimGrid one would set out only when waited for; so would a large one with MPI where that needs both
  /// ends.
  void await(int from, Phase phase, int messages = 1);

  /// To be called now and then while this rank computes: messages travel meanwhile. Never throws, and never waits.
  void progress() noexcept { transport_->progress(); }

  /// Waits for the message of this phase and stamp from a rank. Throws CommError for any other, Stalled, or what
  /// Watch::while_waiting throws. `hops`: how many ranks further on the silent one may be; waits so much longer.
  Message expect(int from, Phase phase, Stamp stamp, int hops = 0);

  /// Memory of a message that is no longer needed, for a later one of its phase that arrives here.
  void reuse(Message message);

  /// Waits until all posted messages have left: their receivers must take part.
  void flush();

  /// Collective: the end of all conversations. Waits until all messages have left and all ranks are here, and gives
  /// back what the transport holds. A communicator that is destroyed without it (the run failed) leaves that to MPI's
  /// own end, since the other ranks may not be there to agree.
  void finish();

  /// Whether ranks are processes, which may share memory where they are on one host; the same on all of them.
  bool between_processes() const { return transport_->between_processes(); }

  /// Whether those that are left can go on when a rank is lost. Then any call may throw RankLost, and does so from then
  /// on (see Transport).
  bool survives() const { return transport_->survives(); }

  /// Lets every rank's calls throw RankLost, so that nobody waits for one that recovers. Not collective.
  void revoke() { transport_->revoke(); }

  /// Collective among the ranks that live, when RankLost was thrown: one for them alone, in the order of their ranks.
  /// `survivors`: the old rank of each. It goes on counting seconds and bytes, and its Watch still hears and speaks of
  /// the ranks of this one until set_watch(). Waits with this one's Watch; throws as any wait does.
  std::unique_ptr<Communicator> shrink(std::vector<int>& survivors);

  const Watch& watch() const { return watch_; }
  void set_watch(Watch watch) { watch_ = std::move(watch); }

  /// What MPI_Comm_f2c takes, for messages beside these; -1 without MPI.
  int handle() const { return transport_->handle(); }

  /// Seconds spent waiting and bytes sent to other ranks so far.
  double waited_s() const { return ledger_.waited_s(); }
  std::uint64_t bytes_sent() const { return bytes_sent_; }

  /// Where this rank's time goes.
  Ledger& ledger() { return ledger_; }

 private:
  template <class Pending>
  void wait(const std::string& purpose, double times, Waited whom, const Pending& pending);
  void carry(int to, Phase phase, std::shared_ptr<const Message> message);
  Message take_own(Phase phase);

  std::unique_ptr<Transport> transport_;
  Watch watch_;
  std::deque<Message> mailbox_;  // to oneself
  Ledger ledger_;
  std::uint64_t bytes_sent_ = 0;
};

}  // namespace motes::comm
