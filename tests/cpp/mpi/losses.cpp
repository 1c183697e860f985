// Ranks of a real MPI that are killed while others wait for them. Arguments: what the others do meanwhile (receive,
// send, compute, finish, shrink or anything), the ranks that die, separated by commas, and the seconds until the first
// one dies. Prints a line per survivor: its old rank, and the ranks that are left.
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "comm/clock.h"
#include "comm/communicator.h"
#include "comm/environment.h"
#include "comm/mpi_transport.h"

using namespace motes::comm;

namespace {

constexpr std::size_t kLarge = 8 << 20;  // MPI moves this much only while both sides call it

void sleep_s(double seconds) {
  const timespec time{static_cast<time_t>(seconds), static_cast<long>((seconds - static_cast<int>(seconds)) * 1e9)};
  nanosleep(&time, nullptr);
}

void die_after(double seconds) {
  sleep_s(seconds);
  kill(getpid(), SIGKILL);
}

Message large() {
  Message message;
  std::memset(message.bytes().extend(kLarge), 0x11, kLarge);
  return message;
}

// Each rank sends to all, in rounds.
void session(Communicator& comm, std::uint32_t first, std::uint32_t rounds) {
  for (std::uint32_t turn = first; turn < first + rounds; ++turn) {
    for (int to = 0; to < comm.size(); ++to) comm.post(to, Phase::exchange, {0, turn}, Message());
    for (int from = 0; from < comm.size(); ++from) comm.expect(from, Phase::exchange, {0, turn});
  }
}

struct Plan {
  std::string meanwhile;
  std::vector<int> victims;
  double after_s;

  bool dies(int rank) const { return std::find(victims.begin(), victims.end(), rank) != victims.end(); }
};

void wait_for_losses(Communicator& comm, const Plan& plan) {
  const int self = comm.rank();
  const int victim = plan.victims.front();
  if (plan.meanwhile == "anything") {
    if (plan.dies(self)) std::thread(die_after, plan.after_s).detach();
    for (std::uint32_t turn = 0;; ++turn) session(comm, turn, 1);
  }
  if (plan.dies(self)) die_after(plan.after_s);
  if (plan.meanwhile == "receive") comm.expect(self == 0 ? victim : 0, Phase::loads, {});
  if (plan.meanwhile == "send") {
    comm.post(victim, Phase::loads, {}, large());
    comm.flush();
  }
  if (plan.meanwhile == "compute") {
    comm.post(victim, Phase::loads, {}, large());
    comm.await(victim, Phase::loads);
    for (const double start = wall_seconds(); wall_seconds() - start < plan.after_s + 1;) comm.progress();
    comm.expect(victim, Phase::loads, {});
  }
  if (plan.meanwhile == "finish") comm.finish();
}

void come_through(const Environment& mpi, const Plan& plan) {
  auto comm = std::make_unique<Communicator>(make_mpi(mpi.world()), Watch{});
  std::vector<int> ranks;
  for (int rank = 0; rank < comm->size(); ++rank) ranks.push_back(rank);
  for (int losses = 0;;) {
    try {
      if (losses == 0) wait_for_losses(*comm, plan);
      if (losses > 0) {
        comm->revoke();
        if (plan.meanwhile == "shrink" && plan.dies(ranks[static_cast<std::size_t>(comm->rank())])) die_after(0.001);
        std::vector<int> survivors;
        auto left = comm->shrink(survivors);
        for (int& rank : survivors) rank = ranks[static_cast<std::size_t>(rank)];
        ranks = survivors;
        comm = std::move(left);
      }
      session(*comm, 0, 20);
      comm->finish();
      break;
    } catch (const RankLost&) {
      ++losses;
    }
  }
  std::string line = "rank " + std::to_string(mpi.rank()) + " came through with";
  for (const int rank : ranks) line.append(" ").append(std::to_string(rank));
  std::puts(line.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 4) return 2;
  try {
    Plan plan{arguments[1], {}, std::stod(arguments[3])};
    std::istringstream victims(arguments[2]);
    for (std::string rank; std::getline(victims, rank, ',');) plan.victims.push_back(std::stoi(rank));
    const Environment mpi(count, arguments);
    come_through(mpi, plan);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
