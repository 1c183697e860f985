#include <sched.h>
#include <time.h>

#include <algorithm>
#include <deque>
#include <exception>
#include <list>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "comm/clock.h"
#include "comm/mpi/calls.h"
#include "comm/mpi/losses.h"

namespace motes::comm::MOTES_MPI_ABI {
namespace {

struct Sending {
  int to;
  std::shared_ptr<const Message> message;
  std::vector<MPI_Request> requests;
};

// A message of which some pieces have arrived. While a request is active MPI may write into the bytes.
struct Receiving {
  base::Bytes bytes;
  MPI_Request request = MPI_REQUEST_NULL;

  bool whole() const {
    return request == MPI_REQUEST_NULL && !bytes.empty() && bytes.size() >= whole_length(bytes.view());
  }
};

// All memory that MPI may read and write between two of our calls.
struct UnderWay {
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Request request = MPI_REQUEST_NULL;  // of the collective in progress
  MPI_Request agreement = MPI_REQUEST_NULL;
  int finished = 0;  // whether all ranks have finished, once they have agreed
  int come = 1;
  std::list<Sending> sending;
  std::map<std::pair<int, Phase>, Receiving> receiving;  // by sender

  bool idle() const {
    return request == MPI_REQUEST_NULL && agreement == MPI_REQUEST_NULL && sending.empty() &&
           std::all_of(receiving.begin(), receiving.end(),
                       [](const auto& of) { return of.second.request == MPI_REQUEST_NULL; });
  }
};

// Keeps what a failed run leaves behind until the process ends. MPI may use this memory in any of its calls until
// MPI_Finalize: a matched receive and a duplication cannot be cancelled, a send only in some MPI libraries.
void keep_for_ever(std::unique_ptr<UnderWay> left) {
  static auto& all = *new std::vector<std::unique_ptr<UnderWay>>;
  all.push_back(std::move(left));
}

// Waits in rounds: first busy, then yielding, then napping. With more ranks than cores, the awaited rank may need this
// one's core. If a yield returns at once, no other process needs the core, and a nap would only add latency: 0.1 ms and
// more on virtual machines. While messages are in flight, which may need both ends for each of their pieces, naps start
// later still.
class BackOff {
 public:
  static constexpr int kBusy = 50, kPolite = 200, kAlone = 1500;  // rounds: about 2 ms together
  static constexpr int kUnderWay = 60000;                         // rounds: some 50 ms

  void pause(int round, bool under_way) {
    if (round < kBusy) {
      crowded_ = false;
      naps_ = 0;
    } else if (round < kPolite || (!crowded_ && round < (under_way ? kUnderWay : kAlone))) {
      const double start = wall_seconds();
      sched_yield();
      crowded_ |= wall_seconds() - start > kAtOnce;
    } else {
      nap();
    }
  }

 private:
  static constexpr double kAtOnce = 20e-6;              // s
  static constexpr int kShort = 800, kMiddling = 1200;  // naps

  // Sleeps, longer as the wait lasts: a wait of 0.1 s or more is for a script, a disk or a paused run and should use no
  // CPU.
  void nap() {
    const timespec nap{0, naps_ < kShort ? 20000 : naps_ < kMiddling ? 200000 : 2000000};
    nanosleep(&nap, nullptr);
    if (naps_ < kMiddling) ++naps_;
  }

  bool crowded_ = false;
  int naps_ = 0;
};

class MpiTransport : public Transport {
  using Source = std::pair<int, Phase>;
  using Awaited = std::map<Source, int>;  // number of messages

  static constexpr double kProgressEvery = 50e-6;  // s
  static constexpr std::size_t kAskedTogether = 4;  // awaited sources polled per call: there may be thousands
  static constexpr std::size_t kSpare = 16;  // buffers kept per phase

 public:
  explicit MpiTransport(MPI_Comm users)
      : users_(users), survives_(losses::survived()), way_(std::make_unique<UnderWay>()) {
    count(users);
  }

  /// Makes a transport over a communicator of the surviving ranks.
  static std::unique_ptr<MpiTransport> among(MPI_Comm left) {
    auto made = std::make_unique<MpiTransport>(left);
    made->way_->comm = left;
    made->open();
    return made;
  }

  ~MpiTransport() override {
    int finalized = 0;
    MPI_Finalized(&finalized);
    if (finalized != 0) return;
    if (!way_->idle() || lost_) {
      keep_for_ever(std::move(way_));
    } else if (way_->comm != MPI_COMM_NULL && size_ == 1) {
      MPI_Comm_free(&way_->comm);
    }
    // With other ranks MPI_Comm_free is collective, and without finished() they may never call it.
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  bool entered() override {
    if (entered_) return true;
    if (lost_) lose();
    if (survives_ && size_ > 1) return enter_surviving();
    if (!entering_) {
      entering_ = true;
      checked(MPI_Comm_idup(users_, &way_->comm, &way_->request), "duplicating the communicator");
    }
    if (done(way_->request, "duplicating the communicator")) {
      open();
    }
    return entered_;
  }

  void send(int to, Phase phase, std::shared_ptr<const Message> message) override {
    if (way_->comm == MPI_COMM_NULL) throw CommError("a message was sent after all ranks had finished");
    check_way();
    if (way_->sending.size() >= sweep_at_) {
      sweep();
      sweep_at_ = 2 * way_->sending.size() + 16;
    }
    way_->sending.push_back({to, std::move(message), {}});
    Sending& sending = way_->sending.back();
    const base::Bytes& bytes = sending.message->bytes();
    for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
      const std::size_t length = std::min(kPiece, bytes.size() - at);
      sending.requests.push_back(MPI_REQUEST_NULL);
      checked(MPI_Isend(bytes.data() + at, static_cast<int>(length), MPI_BYTE, to, tag(phase), way_->comm,
                        &sending.requests.back()),
              "sending a message");
    }
  }

  void await(int from, Phase phase, int messages) override {
    int& awaited = awaited_[{from, phase}];
    awaited = std::max(awaited, messages);
  }

  std::optional<base::Bytes> receive(int from, Phase phase) override {
    check_way();
    const Source source{from, phase};
    if (const auto early = early_.find(source); early != early_.end()) {
      base::Bytes bytes = std::move(early->second.front());
      early->second.pop_front();
      if (early->second.empty()) early_.erase(early);
      return bytes;
    }
    Receiving& next = way_->receiving[source];
    if (!take_pieces(source, next)) return std::nullopt;
    if (const auto found = awaited_.find(source); found != awaited_.end()) count_down(found);
    return std::exchange(next.bytes, {});
  }

  std::optional<int> unsent() override {
    check_way();
    if (survives_ && losses::revoked(way_->comm)) lose();
    sweep();
    if (way_->sending.empty()) return std::nullopt;
    return way_->sending.front().to;
  }

  bool finished() override {
    if (way_->comm == MPI_COMM_NULL) return true;
    check_way();
    if (!finishing_) {
      finishing_ = true;
      checked(MPI_Ibarrier(way_->comm, &way_->request), "finishing");
    }
    if (!done(way_->request, "finishing")) return false;
    // If a rank dies meanwhile, the barrier may succeed here and fail elsewhere: see shrink().
    if (survives_ && !decided(1)) return false;
    if (survives_ && way_->finished == 0) lose();
    const bool whole = !survives_ || losses::lost_rank(way_->comm) < 0;
    if (whole) check(MPI_Comm_free(&way_->comm), "freeing the communicator");  // all ranks are here
    way_->comm = MPI_COMM_NULL;
    return true;
  }

  void pause(int round, double) override {
    if (!lost_) sweep();
    back_off_.pause(round, round >= BackOff::kAlone && !way_->idle());
  }

  // Keeps an error for the next call of a conversation, which throws it.
  void progress() noexcept override {
    if (lost_ || late_ || way_->comm == MPI_COMM_NULL || (way_->sending.empty() && awaited_.empty())) return;
    const double now = wall_seconds();
    if (now < next_progress_s_) return;
    next_progress_s_ = now + kProgressEvery;
    try {
      sweep();
      for (std::size_t i = std::min(awaited_.size(), kAskedTogether); i > 0 && !awaited_.empty(); --i) take_early();
    } catch (...) {
      late_ = std::current_exception();
    }
  }

  bool between_processes() const override { return true; }

  bool survives() const override { return survives_; }

  void revoke() override {
    if (!recoverable()) return Transport::revoke();
    lost_ = true;
    losses::revoke(way_->comm);
  }

  // Each rank takes part in two agreements. The first decides for all whether the run finished before the loss; a rank
  // in finished() votes there. The second completes when all have come, so MPI's own shrink need not wait.
  std::unique_ptr<Transport> shrink(std::vector<int>& survivors) override {
    if (!recoverable()) return Transport::shrink(survivors);
    if (!decided(0)) return nullptr;
    if (way_->finished != 0) throw CommError("the other ranks have finished");
    if (!coming_) {
      coming_ = true;
      losses::agree(way_->comm, &way_->come, &way_->agreement);
    }
    if (!agreed()) return nullptr;
    auto left = among(losses::shrunk(way_->comm));
    survivors = left->ranks_in(way_->comm);
    return left;
  }

  void reuse(Phase phase, base::Bytes memory) override {
    std::vector<base::Bytes>& spare = spare_[phase];
    if (spare.size() == kSpare) return;
    memory.clear();
    spare.push_back(std::move(memory));
  }

  int handle() const override { return entered_ && way_->comm != MPI_COMM_NULL ? MPI_Comm_c2f(way_->comm) : -1; }

 private:
  void count(MPI_Comm comm) {
    check(MPI_Comm_rank(comm, &rank_), "getting the rank");
    check(MPI_Comm_size(comm, &size_), "getting the number of ranks");
  }

  // Makes MPI return error codes, which checked() turns into exceptions, whatever error handler the user has set.
  void open() {
    check(MPI_Comm_set_errhandler(way_->comm, MPI_ERRORS_RETURN), "setting the error handler");
    entered_ = true;
  }

  // Shrinks instead of duplicating: Open MPI 5.0 crashes if a rank is lost during a duplication, which lasts until all
  // ranks have come here. The user's communicator is not ours to revoke, so each rank detects a loss by itself.
  bool enter_surviving() {
    entering_ = true;
    way_->comm = losses::shrunk(users_);
    int left = 0;
    check(MPI_Comm_size(way_->comm, &left), "getting the number of ranks");
    if (left < size_) lose();
    open();
    return true;
  }

  bool recoverable() const { return survives_ && entered_ && way_->comm != MPI_COMM_NULL; }

  std::vector<int> ranks_in(MPI_Comm old) const {
    MPI_Group ours = MPI_GROUP_NULL;
    MPI_Group theirs = MPI_GROUP_NULL;
    check(MPI_Comm_group(way_->comm, &ours), "getting the remaining ranks");
    check(MPI_Comm_group(old, &theirs), "getting the earlier ranks");
    std::vector<int> own(static_cast<std::size_t>(size_));
    std::vector<int> ranks(own.size());
    std::iota(own.begin(), own.end(), 0);
    check(MPI_Group_translate_ranks(ours, size_, own.data(), theirs, ranks.data()), "getting the remaining ranks");
    MPI_Group_free(&ours);
    MPI_Group_free(&theirs);
    return ranks;
  }

  void checked(int code, const char* what) {
    if (code != MPI_SUCCESS && survives_ && (losses::is_loss(code) || someone_is_lost())) lose();
    check(code, what);
  }

  // Returns whether a loss is known. A duplication or barrier in which a rank dies may report it as an internal error.
  bool someone_is_lost() const {
    const MPI_Comm comm = entered_ ? way_->comm : users_;
    return losses::lost_rank(comm) >= 0 || losses::revoked(comm);
  }

  // Throws an earlier error or loss, before this rank sends or asks anything.
  void check_way() {
    if (late_) std::rethrow_exception(std::exchange(late_, nullptr));
    if (lost_) lose();
  }

  [[noreturn]] void lose() {
    lost_ = true;
    throw RankLost(losses::lost_rank(entered_ ? way_->comm : users_));
  }

  bool done(MPI_Request& request, const char* what) {
    int done = 0;
    checked(MPI_Test(&request, &done, MPI_STATUS_IGNORE), what);
    return done != 0;
  }

  // Returns whether the ranks have agreed on whether all have finished. `vote`: 1 if this rank has.
  bool decided(int vote) {
    if (decided_) return true;
    if (way_->agreement == MPI_REQUEST_NULL) {
      way_->finished = vote;
      losses::agree(way_->comm, &way_->finished, &way_->agreement);
    }
    return decided_ = agreed();
  }

  // Returns whether the agreement is complete. It may also report losses.
  bool agreed() {
    int done = 0;
    const int code = MPI_Test(&way_->agreement, &done, MPI_STATUS_IGNORE);
    if (!losses::is_loss(code)) check(code, "agreeing");
    return way_->agreement == MPI_REQUEST_NULL;
  }

  void count_down(Awaited::iterator awaited) {
    if (--awaited->second == 0) awaited_.erase(awaited);
  }

  // Continues to receive the message of one awaited source, the next one at each call.
  void take_early() {
    auto awaited = awaited_.upper_bound(last_early_);
    if (awaited == awaited_.end()) awaited = awaited_.begin();
    last_early_ = awaited->first;
    Receiving& next = way_->receiving[last_early_];
    if (!take_pieces(last_early_, next)) return;
    early_[last_early_].push_back(std::exchange(next.bytes, {}));
    count_down(awaited);
  }

  // Returns whether the whole message has arrived.
  bool take_pieces(const Source& source, Receiving& next) {
    const auto [from, phase] = source;
    while (!next.whole()) {
      if (next.request == MPI_REQUEST_NULL && !begin_piece(from, phase, next)) return false;
      if (!done(next.request, "receiving a message")) return false;
    }
    return true;
  }

  bool begin_piece(int from, Phase phase, Receiving& next) {
    int here = 0;
    MPI_Message arriving = MPI_MESSAGE_NULL;
    MPI_Status status;
    checked(MPI_Improbe(from, tag(phase), way_->comm, &here, &arriving, &status), "waiting for a message");
    if (here == 0) return false;
    int length = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &length), "reading a message");
    const auto size = static_cast<std::size_t>(length);
    if (std::vector<base::Bytes>& spare = spare_[phase]; !spare.empty() && next.bytes.empty()) {
      if (size <= spare.back().capacity()) next.bytes = std::move(spare.back());
      spare.pop_back();
    }
    checked(MPI_Imrecv(next.bytes.extend(size), length, MPI_BYTE, &arriving, &next.request), "receiving a message");
    return true;
  }

  // Releases messages that have left.
  void sweep() {
    for (auto it = way_->sending.begin(); it != way_->sending.end();) {
      bool all_done = true;
      for (MPI_Request& request : it->requests) all_done = done(request, "sending a message") && all_done;
      it = all_done ? way_->sending.erase(it) : std::next(it);
    }
  }

  MPI_Comm users_;
  int rank_ = 0;
  int size_ = 1;
  bool survives_;
  bool entering_ = false;
  bool entered_ = false;
  bool finishing_ = false;
  bool lost_ = false;  // a rank is lost: every call throws
  std::map<Phase, std::vector<base::Bytes>> spare_;  // see reuse()
  bool decided_ = false;  // the ranks have agreed on way_->finished
  bool coming_ = false;  // this rank has called shrink()
  std::size_t sweep_at_ = 16;  // number of messages in flight at which send() sweeps
  Awaited awaited_;
  std::map<Source, std::deque<base::Bytes>> early_;  // whole messages that no receive() has asked for yet, in order
  Source last_early_{-1, Phase{}};  // the source that progress() polled last
  double next_progress_s_ = 0;
  std::exception_ptr late_;  // error of progress(), for the next call to throw
  BackOff back_off_;
  std::unique_ptr<UnderWay> way_;
};

}  // namespace

std::unique_ptr<Transport> connect(MPI_Comm users) { return std::make_unique<MpiTransport>(users); }

void keep_mpi_time() {}  // the machine's clock is used

}  // namespace motes::comm::MOTES_MPI_ABI
