// Large messages between two ranks, one of which computes and only lets messages progress. Argument: a file whose
// existence ends the computation. Prints one line per failed check; then the exit code is 1.
#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <cstring>

#include "check.h"
#include "comm/clock.h"
#include "comm/communicator.h"
#include "comm/environment.h"
#include "comm/mpi_transport.h"

using namespace motes::comm;

namespace {

constexpr std::size_t kLarge = 1 << 20;  // MPI moves this much only while both sides call it
constexpr int kMessages = 5;
constexpr double kLimit = 30;  // seconds

// Messages of different lengths.
std::size_t length(int number) { return kLarge + static_cast<std::size_t>(number % 3) * 4096; }

Message message(int number) {
  Message made;
  std::memset(made.bytes().extend(length(number)), number, length(number));
  return made;
}

void post_all(Communicator& comm, int first) {
  for (int i = first; i < first + kMessages; ++i) comm.post(1, Phase::tiles, {}, message(i));
}

void take_all(Communicator& comm, int first) {
  for (int i = first; i < first + kMessages; ++i) {
    Message taken = comm.expect(0, Phase::tiles, {});
    bool same = taken.payload().size() == length(i);
    for (const std::byte byte : taken.payload()) same = same && byte == std::byte(i);
    check(same, 1, "a message is another than was posted, or comes out of turn");
    comm.reuse(std::move(taken));
  }
}

class Sign {
 public:
  explicit Sign(const char* path) : path_(path) {}

  void put() const {
    std::FILE* file = std::fopen(path_, "w");
    if (file != nullptr) std::fclose(file);
  }
  void remove() const { std::remove(path_); }

  // Computes until the sign is there. Only progress() can have moved messages by then.
  bool compute(Communicator& comm) const {
    for (const double start = wall_seconds(); wall_seconds() - start < kLimit;) {
      comm.progress();
      if (access(path_, F_OK) == 0) return true;
    }
    return false;
  }

 private:
  const char* path_;
};

// Rank 1 computes until rank 0's messages have left; then it receives them, and more that follow.
void receiver_computes(const Environment& mpi, Communicator& comm, const Sign& sign) {
  if (mpi.rank() == 0) {
    post_all(comm, 10);
    comm.flush();
    sign.put();
    post_all(comm, 10 + kMessages);
  } else {
    comm.await(0, Phase::tiles, 2);
    comm.await(0, Phase::tiles, kMessages);
    comm.await(0, Phase::tiles, 1);  // which is among them
    check(sign.compute(comm), 1, "awaited messages did not arrive while it computed");
    take_all(comm, 10);
    take_all(comm, 10 + kMessages);
  }
}

// Rank 0 computes until rank 1 has all of its messages.
void sender_computes(const Environment& mpi, Communicator& comm, const Sign& sign) {
  if (mpi.rank() == 0) {
    post_all(comm, 20);
    check(sign.compute(comm), 0, "its messages did not leave while it computed");
  } else {
    take_all(comm, 20);
    sign.put();
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) return 2;
  const Environment mpi(count, arguments);
  const Sign sign(arguments[1]);
  Communicator comm(make_mpi(mpi.world()), {});
  receiver_computes(mpi, comm, sign);
  mpi.first(false);
  if (mpi.rank() == 0) sign.remove();
  mpi.first(false);
  sender_computes(mpi, comm, sign);
  comm.finish();
  comm.progress();  // nothing is under way any more
  if (mpi.first(failures > 0) >= 0) return 1;
  if (mpi.rank() == 0) std::puts("messages travelled");
  return 0;
}
