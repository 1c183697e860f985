// The manager's messages to all ranks and back, along trees of several shapes, in many orders of events.
#include <string>

#include "comm/clock.h"
#include "comm/simulated_ranks.h"
#include "engine/session/relay.h"
#include "support/check.h"

namespace motes::test_relay {
using comm::Phase;
using comm::SimulatedRank;
using comm::Stamp;

namespace {

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

// Returns texts of different lengths, some of them empty.
std::string words(int rank, std::uint32_t turn) {
  return std::string(static_cast<std::size_t>(rank) % 5 * 7, static_cast<char>('a' + rank % 26)) + std::to_string(turn);
}
std::string own_words(int rank, std::uint32_t turn) { return rank % 3 == 0 ? "" : words(rank, turn); }

void tell(engine::Relay& relay, int size, Stamp stamp) {
  base::Bytes common;
  const std::string all = "for all " + std::to_string(stamp.turn);
  common.put_raw(all.data(), all.size());
  std::vector<engine::RankMessage> parts(static_cast<std::size_t>(size));
  for (int rank = 0; rank < size; ++rank) {
    engine::RankMessage& part = parts[static_cast<std::size_t>(rank)];
    const std::string own = own_words(rank, stamp.turn);
    part.bytes.put_raw(own.data(), own.size());
    part.count = static_cast<std::uint64_t>(rank);
  }
  relay.tell(Phase::begin, stamp, common, parts, stamp.turn % 4 == 3);
}

void hear(engine::Relay& relay, int rank, Stamp stamp) {
  const engine::ManagerMessage message = relay.hear(Phase::begin, stamp);
  CHECK(text_of(message.common) == "for all " + std::to_string(stamp.turn));
  CHECK(text_of(message.own) == own_words(rank, stamp.turn));
  CHECK(message.count == static_cast<std::uint64_t>(rank) && message.failed == (stamp.turn % 4 == 3));
}

void listen(engine::Relay& relay, int size, Stamp stamp) {
  const engine::Answers answers = relay.listen(Phase::report, stamp);
  CHECK(static_cast<int>(answers.ranks.size()) == size);
  for (int rank = 0; rank < size; ++rank) {
    const engine::Answer& one = answers.ranks[static_cast<std::size_t>(rank)];
    CHECK(text_of(one.bytes) == words(rank, stamp.turn) && one.failed == (rank % 7 == 5));
  }
}

// Runs a frame's exchange with the manager: it sends to all, all receive and answer, it collects. The first one is
// flat.
void converse(SimulatedRank& self, const roles::Cast& cast, int fan_out, std::uint32_t turns) {
  comm::Communicator comm(self.transport(), {});
  engine::Relay relay(comm, cast);
  for (std::uint32_t turn = 0; turn < turns; ++turn) {
    const Stamp stamp{3, turn};
    const bool manages = comm.rank() == cast.manager;
    if (manages) tell(relay, comm.size(), stamp);
    hear(relay, comm.rank(), stamp);
    relay.say(Phase::report, stamp, bytes_of(words(comm.rank(), turn)), comm.rank() % 7 == 5);
    if (manages) listen(relay, comm.size(), stamp);
    relay.hand_up(Phase::report, stamp);
    if (turn == 0) relay.grow(cast, fan_out);
  }
  comm.finish();
}

}  // namespace

TEST(relay_reaches_all_ranks_and_brings_their_answers_for_any_tree) {
  for (const int ranks : {1, 2, 3, 4, 5, 8, 9, 17, 33, 64}) {
    for (const int fan_out : {1, 2, 3, 8, 100}) {
      for (const roles::Cast& cast : {roles::cast_auto(ranks), roles::cast_shared(ranks)}) {
        comm::simulate({.ranks = ranks, .seed = static_cast<std::uint64_t>(100 * ranks + fan_out)},
                       [&](SimulatedRank& self) { converse(self, cast, fan_out, 3); });
      }
    }
  }
}

TEST(relay_brings_the_same_in_a_thousand_orders_of_events) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    comm::Simulation simulation;
    simulation.ranks = 3 + static_cast<int>(seed % 10);
    simulation.seed = seed;
    const roles::Cast cast = seed % 2 == 0 ? roles::cast_auto(simulation.ranks) : roles::cast_shared(simulation.ranks);
    comm::simulate(simulation, [&](SimulatedRank& self) { converse(self, cast, 1 + static_cast<int>(seed % 4), 5); });
  }
}

TEST(who_stands_next_to_a_silent_rank_speaks_first) {
  // Rank 0, the image generator, is the manager's child; calculators stand in a chain below it.
  for (const int silent : {1, 2, 4, 7}) {
    for (const int fan_out : {1, 2, 8}) {
      double first_s = 1e9;
      std::string first;
      comm::Watch watch;
      watch.warn_s = 1;
      watch.life = [](int) { return comm::Life{comm::Life::State::lives, ""}; };  // so all keep waiting
      watch.warn = [&](const std::string& text) {
        if (!(comm::wall_seconds() < first_s)) return;
        first_s = comm::wall_seconds();
        first = text;
      };
      comm::simulate({.ranks = 9}, [&](SimulatedRank& self) {
        const roles::Cast cast = roles::cast_auto(9);
        comm::Communicator comm(self.transport(), watch);
        engine::Relay relay(comm, cast);
        relay.grow(cast, fan_out);
        if (comm.rank() == silent) comm::spend(6);
        if (comm.rank() == cast.manager) tell(relay, 9, {0, 1});
        hear(relay, comm.rank(), {0, 1});
        relay.say(Phase::report, {0, 1}, {}, false);
        if (comm.rank() == cast.manager) relay.listen(Phase::report, {0, 1});
        relay.hand_up(Phase::report, {0, 1});
      });
      CHECK(first.find("for rank " + std::to_string(silent) + ":") != std::string::npos);
    }
  }
}

TEST(relay_refuses_parts_of_ranks_that_are_not_there) {
  CHECK_THROWS(comm::simulate({.ranks = 4},
                              [](SimulatedRank& self) {
                                const roles::Cast cast = roles::cast_shared(4);
                                comm::Communicator comm(self.transport(), {});
                                engine::Relay relay(comm, cast);
                                // The manager's tree is a chain, the others' is flat.
                                if (comm.rank() == 0) relay.grow(cast, 1);
                                if (comm.rank() == 0) tell(relay, 4, {0, 1});
                                hear(relay, comm.rank(), {0, 1});
                              }),
               std::runtime_error);
}

}  // namespace motes::test_relay
