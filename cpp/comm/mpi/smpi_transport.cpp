// The transport over SimGrid's SMPI. Polling or probing would advance the simulated time, so every call here waits
// inside MPI until the answer is yes, and pause() is never called. The simulator itself reports a deadlock.
#include <simgrid/host.h>

#include <algorithm>
#include <list>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "comm/clock.h"
#include "comm/mpi/calls.h"
#include "comm/mpi/library.h"

namespace motes::comm::smpi {
namespace {

constexpr std::size_t kBallast = std::size_t{1} << 26;

// Returns the number of bytes of a message that are received first; they contain the length of the rest. Messages of
// births come from many ranks at a time, with few births each.
std::size_t beginning(Phase phase) { return std::size_t{1} << (phase == Phase::births ? 10 : 14); }

int ballast_tag(Phase phase) { return 200 + static_cast<int>(phase); }

// Returns a buffer for all simulated ranks, which are threads that run one at a time. The simulator does not copy
// memory of this kind.
void* ballast_bytes() {
  static void* const bytes = SMPI_SHARED_MALLOC(kBallast);
  return bytes;
}

struct Sending {
  std::shared_ptr<const Message> message;
  std::vector<MPI_Request> requests;
};

struct Receiving {
  base::Bytes bytes;
  MPI_Request request = MPI_REQUEST_NULL;
};

class SmpiTransport : public Transport {
 public:
  explicit SmpiTransport(MPI_Comm users) : users_(users) {
    MPI_Comm_rank(users, &rank_);
    MPI_Comm_size(users, &size_);
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  bool entered() override {
    check(MPI_Comm_dup(users_, &comm_), "duplicating the communicator");
    check(MPI_Comm_set_errhandler(comm_, MPI_ERRORS_RETURN), "setting the error handler");
    return true;
  }

  void send(int to, Phase phase, std::shared_ptr<const Message> message) override {
    if (sending_.size() >= sweep_at_) {
      sweep();
      sweep_at_ = 2 * sending_.size() + 16;
    }
    const Header header = message->header();
    sending_.push_back({std::move(message), {}});
    Sending& sending = sending_.back();
    const auto isend = [&](const void* from, std::size_t length, int with_tag) {
      sending.requests.push_back(MPI_REQUEST_NULL);
      check(MPI_Isend(from, static_cast<int>(length), MPI_BYTE, to, with_tag, comm_, &sending.requests.back()),
            "sending a message");
    };
    const base::Bytes& bytes = sending.message->bytes();
    std::size_t length = std::min(beginning(phase), bytes.size());
    for (std::size_t at = 0; at < bytes.size(); at += length, length = std::min(kPiece, bytes.size() - at)) {
      isend(bytes.data() + at, length, tag(phase));
    }
    carry_ballast(header, [&](void* from, std::size_t piece) { isend(from, piece, ballast_tag(phase)); });
    charge_for(header);
  }

  // Starts one receive at a time: the next message starts when it is waited for.
  void await(int from, Phase phase, int) override {
    Receiving& next = awaited_[{from, phase}];
    if (next.request == MPI_REQUEST_NULL) begin(from, phase, next);
  }

  std::optional<base::Bytes> receive(int from, Phase phase) override {
    Receiving next;
    if (const auto found = awaited_.find({from, phase}); found != awaited_.end()) {
      next = std::move(found->second);
      awaited_.erase(found);
    } else {
      begin(from, phase, next);
    }
    MPI_Status status;
    check(MPI_Wait(&next.request, &status), "receiving a message");
    int length = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &length), "reading a message");
    base::Bytes bytes = std::move(next.bytes);
    bytes.resize(static_cast<std::size_t>(length));
    const std::size_t whole = whole_length(bytes.view());
    while (bytes.size() < whole) {
      const std::size_t piece = std::min(kPiece, whole - bytes.size());
      receive_into(bytes.extend(piece), piece, from, tag(phase));
    }
    const auto header = base::Reader(bytes.view()).get<Header>();
    carry_ballast(header, [&](void* into, std::size_t piece) { receive_into(into, piece, from, ballast_tag(phase)); });
    charge_for(header);
    return bytes;
  }

  std::optional<int> unsent() override {
    for (Sending& each : sending_) {
      check(MPI_Waitall(static_cast<int>(each.requests.size()), each.requests.data(), MPI_STATUSES_IGNORE),
            "sending a message");
    }
    sending_.clear();
    return std::nullopt;
  }

  bool finished() override {
    if (comm_ == MPI_COMM_NULL) return true;
    check(MPI_Barrier(comm_), "finishing");
    check(MPI_Comm_free(&comm_), "freeing the communicator");
    return true;
  }

  void pause(int, double) override { throw std::logic_error("a rank under SimGrid must not poll"); }

  void weigh(Weights weights) override { weights_ = weights; }

 private:
  // Returns the simulated size of a message, bytes.
  double weight(const Header& header) const {
    return static_cast<double>(sizeof header + header.payload_bytes) * (header.count > 0 ? weights_.scale : 1);
  }

  // Returns the number of filler bytes that follow a message to make up its simulated size.
  std::size_t ballast(const Header& header) const {
    const double bytes = weight(header) - static_cast<double>(sizeof header + header.payload_bytes);
    return weights_.byte <= 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
  }

  // Spends the time that a message takes at one end.
  void charge_for(const Header& header) const { execute(weights_.message + weights_.byte * weight(header)); }

  // Moves the filler bytes in pieces; `move` sends or receives one.
  template <class Move>
  void carry_ballast(const Header& header, const Move& move) {
    for (std::size_t left = ballast(header); left > 0;) {
      const std::size_t piece = std::min(left, kBallast);
      move(ballast_bytes(), piece);
      left -= piece;
    }
  }

  void receive_into(void* into, std::size_t length, int from, int with_tag) {
    check(MPI_Recv(into, static_cast<int>(length), MPI_BYTE, from, with_tag, comm_, MPI_STATUS_IGNORE),
          "receiving a message");
  }

  void begin(int from, Phase phase, Receiving& next) {
    next.bytes.resize(beginning(phase));
    check(MPI_Irecv(next.bytes.data(), static_cast<int>(next.bytes.size()), MPI_BYTE, from, tag(phase), comm_,
                    &next.request),
          "receiving a message");
  }

  void sweep() {
    for (auto it = sending_.begin(); it != sending_.end();) {
      int all_done = 0;
      check(MPI_Testall(static_cast<int>(it->requests.size()), it->requests.data(), &all_done, MPI_STATUSES_IGNORE),
            "sending a message");
      it = all_done != 0 ? sending_.erase(it) : std::next(it);
    }
  }

  MPI_Comm users_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
  Weights weights_;
  std::size_t sweep_at_ = 16;
  std::list<Sending> sending_;
  std::map<std::pair<int, Phase>, Receiving> awaited_;  // by sender
};

// The clock of the simulated rank that asks.
class SmpiTime : public TimeSource {
 public:
  double now_s() const override { return MPI_Wtime(); }
  void spend(double seconds) override { execute(seconds * sg_host_get_speed(sg_host_self())); }
  void execute(double operations) override {
    if (operations > 0) smpi_execute_flops(operations);
  }
};

}  // namespace

std::unique_ptr<Transport> connect(MPI_Comm users) { return std::make_unique<SmpiTransport>(users); }

void keep_mpi_time() {
  static SmpiTime time;
  set_time_source(&time);
}

}  // namespace motes::comm::smpi

namespace motes::comm {

const MpiLibrary& program_library() { return smpi::library(nullptr); }

}  // namespace motes::comm
