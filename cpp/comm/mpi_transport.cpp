#include "comm/mpi_transport.h"

#include <sched.h>
#include <time.h>

#include <algorithm>
#include <list>
#include <map>
#include <utility>
#include <vector>

#include "comm/mpi_calls.h"

namespace motes::comm {
namespace {

struct Sending {
  int to;
  Message message;
  std::vector<MPI_Request> requests;
};

// A message of which some pieces have arrived. While a request is active MPI may write into the bytes.
struct Receiving {
  particles::Bytes bytes;
  MPI_Request request = MPI_REQUEST_NULL;
};

// All that MPI may read and write by itself, between two calls of ours.
struct UnderWay {
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Request request = MPI_REQUEST_NULL;  // of the collective that is under way
  std::list<Sending> sending;
  std::map<std::pair<int, Phase>, Receiving> receiving;  // by sender

  bool idle() const {
    return request == MPI_REQUEST_NULL && sending.empty() &&
           std::all_of(receiving.begin(), receiving.end(),
                       [](const auto& of) { return of.second.request == MPI_REQUEST_NULL; });
  }
};

// What a failed run leaves behind. A matched receive cannot be cancelled, a send only by MPI libraries that still try,
// a duplication not at all: MPI goes on to use this memory whenever anybody in this process calls it, until
// MPI_Finalize. So it stays until the process ends.
void keep_for_ever(std::unique_ptr<UnderWay> left) {
  static auto& all = *new std::vector<std::unique_ptr<UnderWay>>;
  all.push_back(std::move(left));
}

// First busy, then polite: with more ranks than cores the one waited for needs this one's core.
void back_off(int round) {
  if (round < 50) return;
  if (round < 200) {
    sched_yield();
    return;
  }
  const timespec nap{0, round < 1000 ? 20000 : 200000};
  nanosleep(&nap, nullptr);
}

class MpiTransport : public Transport {
 public:
  explicit MpiTransport(MPI_Comm users) : users_(users), way_(std::make_unique<UnderWay>()) {
    check(MPI_Comm_rank(users, &rank_), "asking for the rank");
    check(MPI_Comm_size(users, &size_), "asking for the number of ranks");
  }

  ~MpiTransport() override {
    int finalized = 0;
    MPI_Finalized(&finalized);
    if (finalized != 0) return;
    if (!way_->idle()) {
      keep_for_ever(std::move(way_));
    } else if (way_->comm != MPI_COMM_NULL && size_ == 1) {
      MPI_Comm_free(&way_->comm);
    }
    // With other ranks MPI_Comm_free is collective, and without finished() nobody knows whether they come here too.
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  bool entered() override {
    if (!entering_) {
      entering_ = true;
      check(MPI_Comm_idup(users_, &way_->comm, &way_->request), "duplicating the communicator");
    }
    if (!done("duplicating the communicator")) return false;
    // Errors come back as codes that check() turns into exceptions; whatever handler the user has is not inherited.
    check(MPI_Comm_set_errhandler(way_->comm, MPI_ERRORS_RETURN), "setting the error handler");
    return true;
  }

  void send(int to, Phase phase, Message message) override {
    if (way_->comm == MPI_COMM_NULL) throw CommError("a message was sent after the end of all conversations");
    if (way_->sending.size() >= sweep_at_) {
      progress();
      sweep_at_ = 2 * way_->sending.size() + 16;
    }
    way_->sending.push_back({to, std::move(message), {}});
    Sending& sending = way_->sending.back();
    const particles::Bytes& bytes = sending.message.bytes();
    for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
      const std::size_t length = std::min(kPiece, bytes.size() - at);
      sending.requests.push_back(MPI_REQUEST_NULL);
      check(MPI_Isend(bytes.data() + at, static_cast<int>(length), MPI_BYTE, to, tag(phase), way_->comm,
                      &sending.requests.back()),
            "sending a message");
    }
  }

  void await(int, Phase) override {}

  std::optional<particles::Bytes> receive(int from, Phase phase) override {
    Receiving& next = way_->receiving[{from, phase}];
    do {
      if (next.request == MPI_REQUEST_NULL && !begin_piece(from, phase, next)) return std::nullopt;
      int done = 0;
      check(MPI_Test(&next.request, &done, MPI_STATUS_IGNORE), "receiving a message");
      if (done == 0) return std::nullopt;
    } while (next.bytes.size() < whole_length(next.bytes.view()));
    return std::exchange(next.bytes, {});
  }

  std::optional<int> unsent() override {
    progress();
    if (way_->sending.empty()) return std::nullopt;
    return way_->sending.front().to;
  }

  bool finished() override {
    if (way_->comm == MPI_COMM_NULL) return true;
    if (!finishing_) {
      finishing_ = true;
      check(MPI_Ibarrier(way_->comm, &way_->request), "finishing");
    }
    if (!done("finishing")) return false;
    check(MPI_Comm_free(&way_->comm), "freeing the communicator");  // all ranks are here
    return true;
  }

  void pause(int round, double) override {
    progress();
    back_off(round);
  }

 private:
  bool done(const char* what) {
    int done = 0;
    check(MPI_Test(&way_->request, &done, MPI_STATUS_IGNORE), what);
    return done != 0;
  }

  bool begin_piece(int from, Phase phase, Receiving& next) {
    int here = 0;
    MPI_Message arriving = MPI_MESSAGE_NULL;
    MPI_Status status;
    check(MPI_Improbe(from, tag(phase), way_->comm, &here, &arriving, &status), "waiting for a message");
    if (here == 0) return false;
    int length = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &length), "reading a message");
    check(MPI_Imrecv(next.bytes.extend(static_cast<std::size_t>(length)), length, MPI_BYTE, &arriving, &next.request),
          "receiving a message");
    return true;
  }

  void progress() {
    for (auto it = way_->sending.begin(); it != way_->sending.end();) {
      int all_done = 0;
      check(MPI_Testall(static_cast<int>(it->requests.size()), it->requests.data(), &all_done, MPI_STATUSES_IGNORE),
            "sending a message");
      it = all_done != 0 ? way_->sending.erase(it) : std::next(it);
    }
  }

  MPI_Comm users_;
  int rank_ = 0;
  int size_ = 1;
  bool entering_ = false;
  bool finishing_ = false;
  std::size_t sweep_at_ = 16;  // this many messages under way before send() looks which have left
  std::unique_ptr<UnderWay> way_;
};

}  // namespace

std::unique_ptr<Transport> make_mpi(int handle) { return std::make_unique<MpiTransport>(live(handle)); }

void keep_mpi_time() {}  // the machine's time will do

}  // namespace motes::comm
