// Lost ranks: the survivors notice, connect to each other and continue, under hundreds of orders of events.
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "comm/clock.h"
#include "comm/communicator.h"
#include "comm/simulated_ranks.h"
#include "support/check.h"

namespace motes::test_losses {
using namespace comm;
using Death = Simulation::Death;

namespace {

constexpr std::uint32_t kRounds = 6;

Message number(std::uint64_t value) {
  Message message;
  message.bytes().put(value);
  return message;
}

// How the run of one rank ended.
struct End {
  std::vector<int> ranks;  // that reached the end with it, by their original numbers
  int losses = 0;
  int named = 0;  // losses whose rank was known
};

struct Outcome {
  std::map<int, End> ends;
  SimulatedRun run;
};

void round_of_all_to_all(Communicator& comm, std::uint32_t turn) {
  for (int to = 0; to < comm.size(); ++to) {
    comm.post(to, Phase::exchange, {7, turn},
              number(static_cast<std::uint64_t>(100 * comm.rank() + to) + 10000 * turn));
  }
  for (int from = 0; from < comm.size(); ++from) {
    const Message message = comm.expect(from, Phase::exchange, {7, turn});
    const auto sent = static_cast<std::uint64_t>(100 * from + comm.rank()) + 10000 * turn;
    CHECK(message.reader().get<std::uint64_t>() == sent);
  }
}

// Sends all to all `kRounds` times, and starts again after each loss, until the survivors reach the end.
End to_the_end(SimulatedRank& self) {
  End end;
  auto comm = std::make_unique<Communicator>(self.transport(), Watch{});
  CHECK(comm->survives());
  for (int rank = 0; rank < comm->size(); ++rank) end.ranks.push_back(rank);
  for (bool recovers = false;;) {
    try {
      if (recovers) {
        std::vector<int> survivors;
        auto left = comm->shrink(survivors);
        CHECK(static_cast<int>(survivors.size()) == left->size());
        std::vector<int> ranks;
        for (const int old : survivors) ranks.push_back(end.ranks[static_cast<std::size_t>(old)]);
        end.ranks = ranks;
        comm = std::move(left);
        CHECK(end.ranks[static_cast<std::size_t>(comm->rank())] == self.rank());
      }
      for (std::uint32_t turn = 0; turn < kRounds; ++turn) round_of_all_to_all(*comm, turn);
      comm->finish();
      return end;
    } catch (const RankLost& lost) {
      recovers = true;
      ++end.losses;
      if (lost.rank() >= 0) ++end.named;
      CHECK_THROWS(comm->flush(), RankLost);  // as does every later call
      comm->revoke();
      comm->revoke();
    }
  }
}

Outcome outcome(std::uint64_t seed, int ranks, const std::vector<Death>& deaths) {
  Outcome result;
  result.run = simulate({.ranks = ranks, .seed = seed, .deaths = deaths, .survives = true}, [&](SimulatedRank& self) {
    End end = to_the_end(self);
    result.ends[self.rank()] = std::move(end);
  });
  return result;
}

// Checks that the survivors have reached the end together: each knows the same ranks, all survivors and perhaps one
// rank that died after the last message.
void check_together(const Outcome& outcome, int ranks) {
  const std::set<int> dead(outcome.run.dead.begin(), outcome.run.dead.end());
  std::vector<int> first;
  for (int rank = 0; rank < ranks; ++rank) {
    CHECK(outcome.ends.contains(rank) == !dead.contains(rank));
    if (dead.contains(rank)) continue;
    const std::vector<int>& its = outcome.ends.at(rank).ranks;
    if (first.empty()) first = its;
    CHECK(its == first);
    CHECK(std::find(its.begin(), its.end(), rank) != its.end());
  }
}

}  // namespace

TEST(without_a_death_connections_that_survive_are_like_others) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Outcome result = outcome(seed, 4, {});
    check_together(result, 4);
    for (const auto& [rank, end] : result.ends) CHECK(end.losses == 0 && end.ranks.size() == 4);
  }
}

TEST(who_is_left_goes_on_wherever_a_rank_dies) {
  int smaller = 0;
  int whole = 0;
  int unnamed = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const int ranks = 2 + static_cast<int>(seed % 5);
    const std::uint64_t point = 1 + seed / 3;
    Outcome result;
    try {
      result = outcome(seed, ranks, {{static_cast<int>(seed) % ranks, point}});
    } catch (const RankLost&) {
      CHECK(point < 10);  // before all had entered, no rank can continue
      continue;
    }
    check_together(result, ranks);
    if (result.run.dead.empty()) continue;
    for (const auto& [rank, end] : result.ends) {
      (static_cast<int>(end.ranks.size()) < ranks ? smaller : whole) += 1;
      CHECK(end.losses <= 2 && (end.losses == 0) == (static_cast<int>(end.ranks.size()) == ranks));
      unnamed += end.losses - end.named;
    }
  }
  CHECK(smaller > 400);
  CHECK(whole > 10);    // died after their last message
  CHECK(unnamed > 50);  // known only from a revocation
}

TEST(a_rank_may_die_at_any_of_its_messages) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const std::uint64_t most = kRounds * 3;
    const Outcome result = outcome(seed, 4, {{static_cast<int>(seed % 4), 1 + seed % most, Death::At::send}});
    CHECK(result.run.dead.size() == 1);
    check_together(result, 4);
    for (const auto& [rank, end] : result.ends) CHECK(end.ranks.size() == 3);
  }
}

TEST(several_ranks_may_die_at_once) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Outcome result =
        outcome(seed, 5, {{1, 2 + seed % 40}, {static_cast<int>(2 + seed % 3), 2 + seed % 40}, {0, 20 + seed % 80}});
    check_together(result, 5);
  }
  // All ranks but one die.
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Outcome result = outcome(seed, 4, {{0, 5}, {1, 9 + seed % 30}, {3, 9 + seed % 17}});
    check_together(result, 4);
    CHECK(result.ends.at(2).ranks == std::vector<int>{2});
  }
}

TEST(a_rank_may_die_among_those_that_recover) {
  int counted_in = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const Outcome result =
        outcome(seed, 5, {{2, 1 + seed % 7, Death::At::send}, {4, 1 + seed / 7 % 3, Death::At::shrink}});
    check_together(result, 5);
    if (result.run.dead.size() < 2) continue;  // a rank made fewer calls than that
    for (const auto& [rank, end] : result.ends) {
      CHECK(end.ranks == (std::vector<int>{0, 1, 3}));
      if (end.losses > 1) ++counted_in;
    }
  }
  CHECK(counted_in > 50);
}

TEST(the_end_or_a_loss_comes_first_for_all) {
  // Deaths when all are about to finish, and some could have finished without the others.
  int finished = 0;
  int recovered = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const Outcome result = outcome(seed, 3, {{static_cast<int>(seed % 3), 30 + seed / 16}});
    check_together(result, 3);
    if (result.run.dead.empty()) continue;
    for (const auto& [rank, end] : result.ends) (end.losses > 0 ? recovered : finished) += 1;
  }
  CHECK(finished > 5 && recovered > 100);
}

TEST(a_loss_is_noticed_by_each_rank_at_a_time_of_its_own_and_again_from_the_same_seed) {
  const auto noticed = [](std::uint64_t seed) {
    std::vector<double> at_s(4);
    simulate({.ranks = 4, .seed = seed, .deaths = {{3, 1, Death::At::send}}, .survives = true},
             [&](SimulatedRank& self) {
               Communicator comm(self.transport(), {});
               if (self.rank() == 3) comm.post(0, Phase::loads, {}, number(0));
               try {
                 comm.expect(3, Phase::loads, {});
               } catch (const RankLost& lost) {
                 CHECK(lost.rank() == 3);
                 CHECK(std::string(lost.what()).starts_with("rank 3 is lost"));
                 at_s[static_cast<std::size_t>(self.rank())] = wall_seconds();
               }
             });
    return at_s;
  };
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const std::vector<double> at_s = noticed(seed);
    CHECK(at_s == noticed(seed));
    CHECK(at_s[0] > 0 && at_s[0] != at_s[1] && at_s[1] != at_s[2]);
  }
}

TEST(a_communicator_of_those_that_are_left_speaks_of_them_by_their_old_numbers) {
  Simulation simulation;
  simulation.ranks = 4;
  simulation.survives = true;
  for (simulation.seed = 0; simulation.seed < 50; ++simulation.seed) {
    simulation.deaths = {{1, 3}};
    std::set<int> waited_for;
    simulate(simulation, [&](SimulatedRank& self) {
      Watch watch;
      watch.describe = [](int rank) { return "old rank " + std::to_string(rank); };
      watch.while_waiting = [&](int rank) { waited_for.insert(rank); };
      Communicator comm(self.transport(), watch);
      std::vector<int> survivors;
      try {
        for (std::uint32_t turn = 0;; ++turn) round_of_all_to_all(comm, turn);
      } catch (const RankLost& lost) {
        CHECK(lost.rank() == 1 || lost.rank() == -1);
      }
      const std::uint64_t sent = comm.bytes_sent();
      const auto left = comm.shrink(survivors);
      CHECK(survivors == (std::vector<int>{0, 2, 3}));
      CHECK(left->bytes_sent() == sent && left->waited_s() >= comm.waited_s());
      if (left->rank() == 2) spend(1);
      if (left->rank() == 2) left->post(1, Phase::loads, {8, 1}, number(1));
      try {
        if (left->rank() == 1) left->expect(2, Phase::loads, {8, 2});
        CHECK(left->rank() != 1);
      } catch (const CommError& error) {
        CHECK(std::string(error.what()).starts_with("old rank 3 sent a message of frame 8, turn 1"));
      }
      left->finish();
    });
    CHECK(waited_for.contains(3) && !waited_for.contains(1));
  }
}

TEST(what_was_under_way_before_a_loss_does_not_arrive_after_it) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    simulate({.ranks = 3, .seed = seed, .deaths = {{2, 1, Death::At::send}}, .survives = true},
             [&](SimulatedRank& self) {
               Communicator comm(self.transport(), {});
               if (self.rank() == 2) comm.post(0, Phase::loads, {}, number(0));
               if (self.rank() == 0) comm.post(1, Phase::records, {7, 1}, number(1));
               try {
                 comm.expect(2, Phase::loads, {});
               } catch (const RankLost& lost) {
                 CHECK(lost.rank() == 2 || lost.rank() == -1);
               }
               std::vector<int> survivors;
               const auto left = comm.shrink(survivors);
               if (left->rank() == 0) left->post(1, Phase::records, {7, 2}, number(2));
               if (left->rank() == 1) CHECK(left->expect(0, Phase::records, {7, 2}).reader().get<std::uint64_t>() == 2);
               left->finish();
             });
  }
}

TEST(a_sealed_message_goes_to_several_ranks_and_is_kept) {
  simulate({.ranks = 3}, [](SimulatedRank& self) {
    Communicator comm(self.transport(), {});
    const auto kept = comm.sealed(Phase::replicas, {3, 1}, number(5), 1);
    if (comm.rank() == 0) {
      for (int to = 0; to < 3; ++to) comm.post(to, kept);
    }
    if (comm.rank() == 0) {
      CHECK(kept->header().count == 1 && kept->reader().get<std::uint64_t>() == 5);
      CHECK(comm.bytes_sent() == 2 * kept->bytes().size());
    }
    const Message message = comm.expect(0, Phase::replicas, {3, 1});
    CHECK(message.reader().get<std::uint64_t>() == 5 && message.header().count == 1);
    comm.finish();
  });
}

TEST(connections_that_do_not_survive_say_so) {
  simulate({.ranks = 2}, [](SimulatedRank& self) {
    Communicator comm(self.transport(), {});
    std::vector<int> survivors;
    CHECK(!comm.survives() && comm.handle() == -1);
    CHECK_THROWS(comm.revoke(), CommError);
    CHECK_THROWS(comm.shrink(survivors), CommError);
    comm.finish();
  });
}

TEST(who_recovers_when_all_have_come_to_the_end_is_told_so) {
  struct GivenUp : std::exception {};
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    int finished = 0;
    simulate({.ranks = 3, .seed = seed, .survives = true}, [&](SimulatedRank& self) {
      Watch watch;
      if (self.rank() == 0) watch.while_waiting = [](int) { throw GivenUp(); };
      Communicator comm(self.transport(), watch);
      if (self.rank() > 0) spend(0.2);
      try {
        comm.finish();
        ++finished;
      } catch (const GivenUp&) {
        std::vector<int> survivors;
        CHECK_THROWS(comm.shrink(survivors), CommError);
      }
    });
    CHECK(finished == 2);
  }
}

}  // namespace motes::test_losses
