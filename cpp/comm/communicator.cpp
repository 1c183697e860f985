#include "comm/communicator.h"

#define OMPI_SKIP_MPICXX
#define MPICH_SKIP_MPICXX
#include <mpi.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <deque>
#include <list>
#include <map>
#include <utility>
#include <vector>

#include "comm/clock.h"

namespace motes::comm {
namespace {

// MPI counts bytes in an int: larger messages travel in pieces, which MPI keeps in order.
constexpr std::size_t kPiece = std::size_t{1} << 30;

#ifdef MOTES_SMPI
constexpr std::size_t kBallast = std::size_t{1} << 26;

// Of a message that is received in parts. Births come from many at a time, a few to a message.
std::size_t beginning(Phase phase) { return std::size_t{1} << (phase == Phase::births ? 10 : 14); }
#else
std::size_t beginning(Phase) { return kPiece; }
#endif

void check(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw CommError(std::string(what) + ": " + std::string(text, static_cast<std::size_t>(length)));
}

int tag(Phase phase) { return 100 + static_cast<int>(phase); }
#ifdef MOTES_SMPI
int ballast_tag(Phase phase) { return 200 + static_cast<int>(phase); }
#endif

#ifndef MOTES_SMPI
constexpr double kWatchEvery = 0.05;

// A rank that waits may wait for one that waits itself. Who stands nearest to the one that stalls must speak first:
// calculators talk to each other and to the image generator before they report, and the manager answers only when
// all have reported. Words that others pass on are waited for a little longer, by the ranks that they pass.
double patience(Phase phase, int hops) {
  const double longer = 0.2 * hops;
  switch (phase) {
    case Phase::report:
    case Phase::proposals: return 1.25 + longer;
    case Phase::begin:
    case Phase::verdict: return 1.5 + longer;
    default: return 1 + longer;
  }
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

#endif

struct Posted {
  Message message;
  std::vector<MPI_Request> requests;
};

struct Mailed {
  Phase phase;
  Message message;
};

}  // namespace

const char* name(Phase phase) {
  constexpr const char* kNames[] = {"begin",  "report",    "verdict", "exchange",  "records",
                                    "gather", "particles", "loads",   "proposals", "births"};
  return kNames[static_cast<std::size_t>(phase)];
}

struct Communicator::State {
  MPI_Comm comm = MPI_COMM_NULL;
  int rank = 0;
  int size = 1;
  Watch watch;
  std::list<Posted> posted;
  std::size_t sweep_at = 16;  // so many posted messages before post() looks which have left
  std::deque<Mailed> mailbox;
  double waited_s = 0;
  std::uint64_t bytes_sent = 0;
  Weights weights;
#ifdef MOTES_SMPI
  struct Awaited {
    particles::Bytes bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };
  std::map<std::pair<int, Phase>, Awaited> awaited;             // by sender
  std::map<std::pair<int, Phase>, MPI_Request>
      awaited_ballast;  // at most 64 MB of it; of the next message that has some
#endif

#ifndef MOTES_SMPI
  // Calls `done` until it says true; gives up after `limits` times the stall limit.
  template <class Done>
  void wait(int for_rank, const std::string& purpose, const Done& done, double limits = 1) {
    if (done()) return;
    const double start = wall_seconds();
    double next_watch = start + kWatchEvery;
    for (int round = 0; !done(); ++round) {
      progress();
      back_off(round);
      const double now = wall_seconds();
      if (now < next_watch) continue;
      next_watch = now + kWatchEvery;
      if (watch.while_waiting) watch.while_waiting(for_rank);
      if (now - start > limits * watch.stall_s) stalled(for_rank, purpose, now - start);
    }
    waited_s += wall_seconds() - start;
  }

  [[noreturn]] void stalled(int for_rank, const std::string& purpose, double seconds) const {
    const std::string whom = for_rank < 0 ? "other ranks" : describe(for_rank);
    throw Stalled(for_rank, describe(rank) + " waited " + std::to_string(static_cast<int>(seconds)) + " s for " + whom +
                                ": " + purpose);
  }

#endif

  std::string describe(int of) const { return watch.describe ? watch.describe(of) : "rank " + std::to_string(of); }

  void progress() {
    for (auto it = posted.begin(); it != posted.end();) {
      int all_done = 0;
      check(MPI_Testall(static_cast<int>(it->requests.size()), it->requests.data(), &all_done, MPI_STATUSES_IGNORE),
            "sending a message");
      it = all_done != 0 ? posted.erase(it) : std::next(it);
    }
  }

#ifdef MOTES_SMPI
  // Bytes that a message of particles weighs.
  double weight(const Header& header) const {
    return static_cast<double>(sizeof header + header.payload_bytes) * (header.count > 0 ? weights.scale : 1);
  }

  // What it weighs above its bytes travels behind it, as bytes that nobody reads.
  std::size_t ballast(const Header& header) const {
    const double bytes = weight(header) - static_cast<double>(sizeof header + header.payload_bytes);
    return weights.byte <= 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
  }

  // The time that it takes at one end.
  void handle(const Header& header) const { execute(weights.message + weights.byte * weight(header)); }

  // In pieces; `move` sends or receives one.
  template <class Move>
  void carry(const Header& header, const Move& move) {
    for (std::size_t left = ballast(header); left > 0;) {
      const std::size_t piece = std::min(left, kBallast);
      move(sea(), static_cast<int>(piece));
      left -= piece;
    }
  }

  // One for all simulated ranks, which are threads that run one after another. The simulator does not copy what lies in
  // memory of this kind.
  static void* sea() {
    static void* const bytes = SMPI_SHARED_MALLOC(kBallast);
    return bytes;
  }

  void await(int from, Phase phase) {
    Awaited& next = awaited[{from, phase}];
    if (next.request == MPI_REQUEST_NULL) begin(from, phase, next);
  }

  void begin(int from, Phase phase, Awaited& next) {
    next.bytes.resize(beginning(phase));
    check(MPI_Irecv(next.bytes.data(), static_cast<int>(next.bytes.size()), MPI_BYTE, from, tag(phase), comm,
                    &next.request),
          "receiving a message");
  }

  // A simulated rank waits inside a receive: polling would let the simulated time pass in steps of its own, and so does
  // MPI_Probe there. A message's beginning says how long the rest is. The simulator itself says so when all ranks wait
  // for ever.
  Message receive(int from, Phase phase, int, const std::string&) {
    const double start = wall_seconds();
    Awaited next;
    if (const auto found = awaited.find({from, phase}); found != awaited.end()) {
      next = std::move(found->second);
      awaited.erase(found);
    } else {
      begin(from, phase, next);
    }
    MPI_Status status;
    check(MPI_Wait(&next.request, &status), "receiving a message");
    int length = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &length), "reading a message");
    particles::Bytes bytes = std::move(next.bytes);
    bytes.resize(static_cast<std::size_t>(length));
    const auto header = particles::Reader(bytes.view()).get<Header>();
    const std::size_t whole = sizeof(Header) + header.payload_bytes;
    while (bytes.size() < whole) {
      const std::size_t piece = std::min(kPiece, whole - bytes.size());
      check(MPI_Recv(bytes.extend(piece), static_cast<int>(piece), MPI_BYTE, from, tag(phase), comm, MPI_STATUS_IGNORE),
            "receiving a message");
    }
    carry(header, [&](void* into, int size) {
      check(MPI_Recv(into, size, MPI_BYTE, from, ballast_tag(phase), comm, MPI_STATUS_IGNORE), "receiving a message");
    });
    handle(header);
    waited_s += wall_seconds() - start;
    return Message(std::move(bytes));
  }

  void duplicate(MPI_Comm users) { check(MPI_Comm_dup(users, &comm), "duplicating the communicator"); }

  void flush() {
    for (Posted& each : posted) {
      check(MPI_Waitall(static_cast<int>(each.requests.size()), each.requests.data(), MPI_STATUSES_IGNORE),
            "sending a message");
    }
    posted.clear();
  }
#else
  void receive_piece(int from, Phase phase, int hops, particles::Bytes& into, const std::string& purpose) {
    MPI_Message arriving = MPI_MESSAGE_NULL;
    MPI_Status status;
    wait(
        from, purpose,
        [&] {
          int here = 0;
          check(MPI_Improbe(from, tag(phase), comm, &here, &arriving, &status), "waiting for a message");
          return here != 0;
        },
        patience(phase, hops));
    int bytes = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &bytes), "reading a message");
    MPI_Request request = MPI_REQUEST_NULL;
    check(MPI_Imrecv(into.extend(static_cast<std::size_t>(bytes)), bytes, MPI_BYTE, &arriving, &request),
          "receiving a message");
    wait(from, purpose, [&] {
      int done = 0;
      check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "receiving a message");
      return done != 0;
    });
  }

  Message receive(int from, Phase phase, int hops, const std::string& purpose) {
    particles::Bytes bytes;
    receive_piece(from, phase, hops, bytes, purpose);
    const std::size_t whole = sizeof(Header) + particles::Reader(bytes.view()).get<Header>().payload_bytes;
    while (bytes.size() < whole) receive_piece(from, phase, hops, bytes, purpose);
    return Message(std::move(bytes));
  }

  void duplicate(MPI_Comm users) {
    MPI_Request request = MPI_REQUEST_NULL;
    check(MPI_Comm_idup(users, &comm, &request), "duplicating the communicator");
    wait(-1, "to enter the world", [&] {
      int done = 0;
      check(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "duplicating the communicator");
      return done != 0;
    });
  }

  void flush() {
    wait(-1, "to take its messages", [&] {
      progress();
      return posted.empty();
    });
  }
#endif

  Message take_own(Phase phase) {
    const auto found = std::find_if(mailbox.begin(), mailbox.end(), [&](const Mailed& m) { return m.phase == phase; });
    if (found == mailbox.end()) throw CommError(describe(rank) + " waits for a message of its own that it never sent");
    Message message = std::move(found->message);
    mailbox.erase(found);
    return message;
  }
};

Communicator::Communicator(int handle, Watch watch) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.watch = std::move(watch);
  const MPI_Comm users = MPI_Comm_f2c(handle);
  if (users == MPI_COMM_NULL) throw CommError("comm must be a live communicator");
  MPI_Comm_rank(users, &s.rank);
  MPI_Comm_size(users, &s.size);
  s.duplicate(users);
  // Errors come back as codes that check() turns into exceptions; whatever handler the user has is not inherited.
  check(MPI_Comm_set_errhandler(s.comm, MPI_ERRORS_RETURN), "setting the error handler");
}

Communicator::~Communicator() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  // With messages under way the job is being given up: freeing would wait for ranks that are gone.
  if (finalized == 0 && state_->posted.empty() && state_->comm != MPI_COMM_NULL) MPI_Comm_free(&state_->comm);
}

int Communicator::rank() const { return state_->rank; }
int Communicator::size() const { return state_->size; }
double Communicator::waited_s() const { return state_->waited_s; }
std::uint64_t Communicator::bytes_sent() const { return state_->bytes_sent; }

void Communicator::post(int to, Phase phase, Stamp stamp, Message message, std::uint64_t count, bool failed) {
  State& s = *state_;
  Header header;
  header.phase = phase;
  header.failed = failed ? 1 : 0;
  header.frame = stamp.frame;
  header.turn = stamp.turn;
  header.count = count;
  message.set_header(header);
  header = message.header();
  if (to == s.rank) {
    s.mailbox.push_back({phase, std::move(message)});
    return;
  }
  if (s.posted.size() >= s.sweep_at) {
    s.progress();
    s.sweep_at = 2 * s.posted.size() + 16;
  }
  s.posted.push_back({std::move(message), {}});
  Posted& posted = s.posted.back();
  const particles::Bytes& bytes = posted.message.bytes();
  std::size_t length = std::min(beginning(phase), bytes.size());
  for (std::size_t at = 0; at < bytes.size(); at += length, length = std::min(kPiece, bytes.size() - at)) {
    posted.requests.push_back(MPI_REQUEST_NULL);
    check(MPI_Isend(bytes.data() + at, static_cast<int>(length), MPI_BYTE, to, tag(phase), s.comm,
                    &posted.requests.back()),
          "sending a message");
  }
#ifdef MOTES_SMPI
  s.carry(header, [&](void* from, int size) {
    posted.requests.push_back(MPI_REQUEST_NULL);
    check(MPI_Isend(from, size, MPI_BYTE, to, ballast_tag(phase), s.comm, &posted.requests.back()),
          "sending a message");
  });
  s.handle(header);
#endif
  s.bytes_sent += bytes.size();
}

void Communicator::weigh(Weights weights) { state_->weights = weights; }

#ifdef MOTES_SMPI
void Communicator::await(int from, Phase phase) {
  if (from != state_->rank) state_->await(from, phase);
}
#else
void Communicator::await(int, Phase) {}
#endif

Message Communicator::expect(int from, Phase phase, Stamp stamp, int hops) {
  State& s = *state_;
  const std::string purpose = std::string("frame ") + std::to_string(stamp.frame) + ", phase " + name(phase);
  Message message = from == s.rank ? s.take_own(phase) : s.receive(from, phase, hops, purpose);
  const Header header = message.header();
  const bool in_step = header.frame == stamp.frame && header.turn == stamp.turn;
  if (header.magic != Header{}.magic || header.phase != phase || !in_step || header.system != kAllSystems ||
      header.payload_bytes != message.payload().size()) {
    throw CommError(s.describe(from) + " sent a message of frame " + std::to_string(header.frame) + ", turn " +
                    std::to_string(header.turn) + " where " + s.describe(s.rank) + " expected " + purpose);
  }
  return message;
}

void Communicator::flush() { state_->flush(); }

std::string library_version() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string whole(text, static_cast<std::size_t>(length));
  return whole.substr(0, whole.find(','));
}

}  // namespace motes::comm
