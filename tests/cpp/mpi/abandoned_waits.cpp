// Two ranks abandon waits while MPI is at work, then reuse their memory: MPI must not touch it. A separate program,
// since only a real MPI writes asynchronously. Prints one line per failed check; then the exit code is 1.
#include <time.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <vector>

#include "check.h"
#include "comm/communicator.h"
#include "comm/environment.h"
#include "comm/mpi_transport.h"

using namespace motes::comm;

namespace {

struct Abandoned : std::exception {};

constexpr std::size_t kLarge = 8 << 20;  // MPI moves this much only while both sides call it

void sleep_s(double seconds) {
  const timespec time{static_cast<time_t>(seconds), static_cast<long>((seconds - static_cast<int>(seconds)) * 1e9)};
  nanosleep(&time, nullptr);
}

// Returns a watch that abandons a wait at its fourth look, after 0.2 s.
Watch impatient() {
  Watch watch;
  watch.while_waiting = [looks = 0](int) mutable {
    if (++looks == 4) throw Abandoned();
  };
  return watch;
}

Message large() {
  Message message;
  std::memset(message.bytes().extend(kLarge), 0x11, kLarge);
  return message;
}

// Fills memory of many sizes, most likely including what was freed a moment ago.
class Scribble {
 public:
  Scribble() {
    for (std::size_t size = 16; size <= 4096; size += 16) blocks_.emplace_back(size, kByte);
    for (int i = 0; i < 4; ++i) blocks_.emplace_back(kLarge + sizeof(Header), kByte);
  }
  bool whole() const {
    for (const std::vector<unsigned char>& block : blocks_) {
      for (const unsigned char byte : block) {
        if (byte != kByte) return false;
      }
    }
    return true;
  }

 private:
  static constexpr unsigned char kByte = 0x5a;
  std::vector<std::vector<unsigned char>> blocks_;
};

bool abandons(const auto& wait) {
  try {
    wait();
  } catch (const Abandoned&) {
    return true;
  }
  return false;
}

// Rank 1 abandons the wait in the middle of a message.
void receive(const Environment& mpi) {
  if (mpi.rank() == 0) {
    Communicator comm(make_mpi(mpi.world()), {});
    comm.post(1, Phase::gather, {}, large());
    sleep_s(0.6);
    mpi.first(false);
    comm.flush();
    mpi.first(false);
  } else {
    {
      Communicator comm(make_mpi(mpi.world()), impatient());
      check(abandons([&] { comm.expect(0, Phase::gather, {}); }), 1, "the message came before it was given up");
    }
    const Scribble memory;
    mpi.first(false);
    mpi.first(false);
    check(memory.whole(), 1, "MPI wrote a message into memory that was given back");
  }
}

// Rank 0 abandons the wait before its message has left; the message must arrive unchanged.
void send(const Environment& mpi) {
  if (mpi.rank() == 0) {
    {
      Communicator comm(make_mpi(mpi.world()), impatient());
      comm.post(1, Phase::gather, {}, large());
      check(abandons([&] { comm.flush(); }), 0, "the message left before it was given up");
    }
    const Scribble memory;
    mpi.first(false);
    check(memory.whole(), 0, "MPI wrote into memory that was given back");
    return;
  }
  Communicator comm(make_mpi(mpi.world()), {});
  sleep_s(0.6);
  const Message message = comm.expect(0, Phase::gather, {});
  bool same = message.payload().size() == kLarge;
  for (const std::byte byte : message.payload()) same = same && byte == std::byte{0x11};
  check(same, 1, "the message is another than was posted");
  mpi.first(false);
}

// Rank 0 abandons the wait before rank 1 has entered.
void enter(const Environment& mpi) {
  if (mpi.rank() == 0) {
    check(abandons([&] { const Communicator comm(make_mpi(mpi.world()), impatient()); }), 0, "it entered alone");
    const Scribble memory;
    mpi.first(false);
    check(memory.whole(), 0, "MPI wrote a communicator into memory that was given back");
    return;
  }
  sleep_s(0.6);
  {
    const Communicator comm(make_mpi(mpi.world()), {});
  }
  mpi.first(false);
}

// Creates worlds one after another, each freed when all ranks have agreed that it is over.
void finish(const Environment& mpi) {
  for (std::uint32_t i = 0; i < 200; ++i) {
    Communicator comm(make_mpi(mpi.world()), {});
    comm.post(1 - mpi.rank(), Phase::loads, {0, i}, {});
    comm.expect(1 - mpi.rank(), Phase::loads, {0, i});
    comm.finish();
  }
}

}  // namespace

int main(int count, char** arguments) {
  const Environment mpi(count, arguments);
  receive(mpi);
  send(mpi);
  enter(mpi);
  finish(mpi);
  if (mpi.first(failures > 0) >= 0) return 1;
  if (mpi.rank() == 0) std::puts("memory is as it was");
  return 0;
}
