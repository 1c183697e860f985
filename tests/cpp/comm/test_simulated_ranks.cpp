// Simulated ranks: one order of events per seed, deadlocks, failures and deaths.
#include <atomic>
#include <set>
#include <string>

#include "comm/clock.h"
#include "comm/communicator.h"
#include "comm/simulated_ranks.h"
#include "support/check.h"

namespace motes::test_simulated_ranks {
using namespace comm;

namespace {

Message number(std::uint64_t value) {
  Message message;
  message.bytes().put(value);
  return message;
}

// Sends all to all, `rounds` times; every rank compares what arrives with what was sent.
void all_to_all(SimulatedRank& self, std::uint32_t rounds) {
  Communicator comm(self.transport(), {});
  for (std::uint32_t turn = 0; turn < rounds; ++turn) {
    for (int to = 0; to < comm.size(); ++to) {
      comm.post(to, Phase::exchange, {7, turn}, number(static_cast<std::uint64_t>(1000 * comm.rank() + to) + turn));
    }
    for (int from = 0; from < comm.size(); ++from) {
      const Message message = comm.expect(from, Phase::exchange, {7, turn});
      CHECK(message.reader().get<std::uint64_t>() == static_cast<std::uint64_t>(1000 * from + comm.rank()) + turn);
    }
  }
  comm.finish();
}

SimulatedRun traced(std::uint64_t seed) {
  Simulation simulation;
  simulation.ranks = 5;
  simulation.seed = seed;
  simulation.trace = true;
  return simulate(simulation, [](SimulatedRank& self) { all_to_all(self, 2); });
}

template <class Body>
std::string error_of(const Simulation& simulation, const Body& body) {
  try {
    simulate(simulation, body);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST(simulated_ranks_repeat_an_order_of_events_from_its_seed) {
  std::set<std::uint64_t> orders;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const SimulatedRun first = traced(seed);
    const SimulatedRun again = traced(seed);
    CHECK(first.events == again.events && first.clocks_s == again.clocks_s);
    CHECK(first.events.size() > 100 && first.fingerprint == again.fingerprint);
    orders.insert(first.fingerprint);
  }
  CHECK(orders.size() == 50);
}

TEST(simulated_ranks_talk_all_to_all_in_any_number) {
  for (int ranks = 1; ranks <= 64; ranks += ranks < 9 ? 1 : 11) {
    const SimulatedRun run = simulate({.ranks = ranks, .seed = static_cast<std::uint64_t>(ranks)},
                                      [](SimulatedRank& self) { all_to_all(self, 1); });
    CHECK(static_cast<int>(run.clocks_s.size()) == ranks && run.dead.empty());
  }
}

TEST(simulated_ranks_run_one_at_a_time) {
  std::atomic<int> inside = 0;
  simulate({.ranks = 16}, [&](SimulatedRank& self) {
    Communicator comm(self.transport(), {});
    for (std::uint32_t turn = 0; turn < 20; ++turn) {
      CHECK(++inside == 1);
      --inside;
      comm.post((comm.rank() + 1) % comm.size(), Phase::loads, {0, turn}, number(turn));
      CHECK(++inside == 1);
      --inside;
      comm.expect((comm.rank() + comm.size() - 1) % comm.size(), Phase::loads, {0, turn});
    }
  });
}

TEST(simulated_time_does_not_depend_on_the_order_of_events) {
  const auto run = [](std::uint64_t seed, std::uint64_t timing) {
    return simulate({.ranks = 7, .seed = seed, .timing_seed = timing}, [](SimulatedRank& self) {
      CHECK(simulated());
      const double before = wall_seconds();
      execute(1e6 * (1 + self.rank()));
      CHECK(wall_seconds() > before && cpu_seconds() == wall_seconds());
      spend(0.25);
      CHECK_NEAR(wall_seconds() - before, 0.25 + 0.001 * (1 + self.rank()), 0.0005 * (1 + self.rank()));
      all_to_all(self, 3);
    });
  };
  const SimulatedRun model = run(0, 5);
  std::set<std::uint64_t> orders;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const SimulatedRun other = run(seed, 5);
    CHECK(other.clocks_s == model.clocks_s);
    orders.insert(other.fingerprint);
  }
  CHECK(orders.size() == 100);
  CHECK(run(0, 6).clocks_s != model.clocks_s);
  CHECK(!simulated());
}

TEST(a_deadlock_says_who_waits_for_whom_on_all_ranks) {
  Simulation simulation;
  simulation.ranks = 4;
  for (simulation.seed = 0; simulation.seed < 100; ++simulation.seed) {
    int told = 0;
    const std::string text = error_of(simulation, [&](SimulatedRank& self) {
      Communicator comm(self.transport(), {});
      if (self.rank() == 3) return;
      try {
        comm.expect((self.rank() + 1) % 4, Phase::report, {1, 2});
      } catch (const Deadlock&) {
        ++told;
        throw;
      }
    });
    CHECK(told == 3);
    CHECK(has(text, "deadlock, all ranks wait"));
    CHECK(has(text, "rank 0 waits for report from rank 1;"));
    CHECK(has(text, "rank 2 waits for report from rank 3, which has returned; rank 3 has returned"));
  }
  const std::string text = error_of(simulation, [](SimulatedRank& self) {
    Communicator comm(self.transport(), {});
    if (self.rank() != 2) comm.finish();
  });
  CHECK(has(text, "rank 3 waits for all to finish"));
}

TEST(a_message_that_nobody_takes_may_keep_its_sender) {
  // As under MPI, a large message stays until its receiver asks for it; half of the timings show this.
  int kept = 0;
  Simulation simulation;
  for (simulation.seed = 0; simulation.seed < 40; ++simulation.seed) {
    const std::string text = error_of(simulation, [](SimulatedRank& self) {
      Communicator comm(self.transport(), {});
      if (self.rank() == 0) comm.post(1, Phase::gather, {}, number(1));
      if (self.rank() == 0) comm.flush();
    });
    if (has(text, "rank 0 waits until its message is taken by rank 1, which has returned")) ++kept;
  }
  CHECK(kept > 5 && kept < 35);
}

TEST(an_exception_on_one_rank_ends_the_run_everywhere) {
  Simulation simulation;
  simulation.ranks = 9;
  for (simulation.seed = 0; simulation.seed < 100; ++simulation.seed) {
    int ended = 0;
    struct Leaves {
      int& count;
      ~Leaves() { ++count; }
    };
    CHECK_THROWS(simulate(simulation,
                          [&](SimulatedRank& self) {
                            const Leaves leaves{ended};
                            Communicator comm(self.transport(), {});
                            if (self.rank() == 4) throw std::out_of_range("rank 4's own");
                            try {
                              for (std::uint32_t turn = 0;; ++turn) {
                                comm.post(8 - self.rank(), Phase::loads, {0, turn}, number(0));
                                comm.expect(8 - self.rank(), Phase::loads, {0, turn});
                              }
                            } catch (const std::exception&) {
                              CHECK(false);  // code of a rank must not catch the end by mistake
                            }
                          }),
                 std::out_of_range);
    CHECK(ended == 9);
  }
}

TEST(a_rank_that_dies_is_noticed) {
  // The others wait for it, check whether it is alive, and learn that it is not.
  for (std::uint64_t point = 1; point < 60; ++point) {
    std::string text = "no death";
    try {
      const SimulatedRun run = simulate({.ranks = 4, .seed = point, .deaths = {{2, point}}}, [&](SimulatedRank& self) {
        Watch watch;
        watch.while_waiting = [&](int) {
          if (!self.alive(2)) throw std::runtime_error("rank 2 is gone");
        };
        Communicator comm(self.transport(), watch);
        for (std::uint32_t turn = 0; turn < 4; ++turn) {
          for (int to = 0; to < 4; ++to) comm.post(to, Phase::exchange, {0, turn}, number(turn));
          for (int from = 0; from < 4; ++from) comm.expect(from, Phase::exchange, {0, turn});
        }
        comm.finish();
      });
      text = run.dead.empty() ? "no death" : "died behind its last message";
    } catch (const std::runtime_error& error) {
      text = error.what();
    }
    CHECK(point < 30 ? text == "rank 2 is gone" : !text.empty());
  }
}

}  // namespace motes::test_simulated_ranks
