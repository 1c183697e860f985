// When a wait warns and when it gives up, with a clock that the test controls.
#include <string>
#include <vector>

#include "comm/clock.h"
#include "comm/communicator.h"
#include "comm/simulated_ranks.h"
#include "comm/wait.h"
#include "support/check.h"

namespace motes::test_wait {
using namespace comm;

namespace {

// Rank 1 waits for rank 3; the clock moves one nap at a time until the wait ends.
struct Waiting {
  explicit Waiting(double limit_s = 0) {
    watch.limit_s = limit_s;
    watch.warn = [this](const std::string& text) { warnings.push_back(text); };
    watch.while_waiting = [this](int rank) { looks.push_back(rank); };
  }

  // Returns the seconds until Stalled, or -1 if it takes longer than `at_most_s`. From `jump_at_s` on the clock is
  // `jump_s` ahead.
  double run(double patience, double at_most_s, double nap_s = 0.01, double jump_at_s = 1e9, double jump_s = 0) {
    Wait wait(watch, 1, "frame 7, phase report", patience, 100);
    for (double t = 0; t < at_most_s; t += nap_s) {
      try {
        wait.look(100 + t + (t >= jump_at_s ? jump_s : 0), 3);
      } catch (const Stalled& stalled) {
        CHECK(stalled.rank() == 3);
        text = stalled.what();
        return t;
      }
    }
    return -1;
  }

  Watch watch;
  std::vector<std::string> warnings;
  std::vector<int> looks;
  std::string text;
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

Life lives() { return {Life::State::lives, ""}; }
Life gone() { return {Life::State::gone, ""}; }

TEST(a_wait_for_a_living_process_never_ends_and_warns_once_per_minute) {
  Waiting waiting;
  waiting.watch.life = [](int rank) { return rank == 3 ? lives() : gone(); };
  CHECK(waiting.run(1, 3610) == -1);
  CHECK(waiting.warnings.size() == 60);
  CHECK(waiting.warnings.at(0) ==
        "rank 1 waited 60 s for rank 3: frame 7, phase report; its process is alive, so it keeps waiting "
        "(MOTES_STALL_S=seconds sets a limit)");
  CHECK(has(waiting.warnings.at(59), "rank 1 waited 3600 s for rank 3"));
  CHECK(waiting.looks.size() > 60'000 && waiting.looks.size() <= 72'200);  // every 50 ms
  waiting.warnings.clear();
  CHECK(waiting.run(1.25, 301) == -1);
  CHECK(waiting.warnings.size() == 4 && has(waiting.warnings.at(0), "waited 75 s"));
}

TEST(a_warning_says_in_which_state_the_process_is) {
  Waiting waiting;
  waiting.watch.life = [](int) { return Life{Life::State::lives, "its process 4711 is stopped"}; };
  CHECK(waiting.run(1, 6000) == -1);
  CHECK(waiting.warnings.size() == 99 &&
        has(waiting.warnings.at(98), "; its process 4711 is stopped, so it keeps waiting"));
}

TEST(a_wait_ends_where_the_process_is_gone) {
  Waiting waiting;
  waiting.watch.life = [](int) { return gone(); };
  waiting.watch.describe = [](int rank) { return rank == 3 ? "rank 3 (calculator 1)" : "rank 1 (manager)"; };
  CHECK_NEAR(waiting.run(1, 1000), 60, 0.1);
  CHECK(waiting.text ==
        "rank 1 (manager) waited 60 s for rank 3 (calculator 1): frame 7, phase report (its process is gone)");
  CHECK(waiting.warnings.empty());
  Waiting patient(3600);  // a longer limit does not delay the end
  patient.watch.life = [](int) { return gone(); };
  CHECK_NEAR(patient.run(1, 1000), 60, 0.1);
}

TEST(a_wait_ends_when_the_process_dies_after_a_warning) {
  Waiting waiting;
  waiting.watch.life = [&](int) { return waiting.warnings.size() < 2 ? lives() : gone(); };
  CHECK_NEAR(waiting.run(1, 1000), 180, 0.2);
  CHECK(waiting.warnings.size() == 2 && has(waiting.text, "is gone"));
}

TEST(where_nobody_can_tell_a_wait_ends_after_ten_minutes_of_warnings) {
  Waiting waiting;
  CHECK_NEAR(waiting.run(1, 2000), 600, 0.3);
  CHECK(waiting.warnings.size() == 9);
  CHECK(has(waiting.warnings.at(0),
            "waited 60 s for rank 3: frame 7, phase report; it is unknown whether its "
            "process is alive, so it waits for 600 s in total (MOTES_STALL_S=seconds changes the limit"));
  CHECK(has(waiting.text,
            "(it is unknown whether its process is alive; increase the limit, by default MOTES_STALL_S=600"));
  CHECK_NEAR(waiting.run(1.5, 2000), 900, 0.5);
}

TEST(a_limit_that_was_set_ends_a_wait_whatever_lives) {
  for (const Life& life : {lives(), gone(), Life{}}) {
    Waiting waiting(2);
    waiting.watch.life = [&](int) { return life; };
    CHECK_NEAR(waiting.run(1, 1000), 2, 0.1);
    CHECK_NEAR(waiting.run(1.25, 1000), 2.5, 0.1);
    CHECK(waiting.warnings.empty());
    CHECK(has(waiting.text, "rank 1 waited 2 s for rank 3"));
    if (life.state != Life::State::gone) CHECK(has(waiting.text, "the limit was set by MOTES_STALL_S=2: increase it"));
  }
  Waiting long_one(1000);
  long_one.watch.life = [&](int) { return lives(); };
  CHECK_NEAR(long_one.run(1, 2000), 1000, 0.5);
  CHECK(long_one.warnings.size() == 16 &&
        has(long_one.warnings.at(0), "until the limit that was set by MOTES_STALL_S=1000"));
}

TEST(a_suspended_process_does_not_count_the_time_as_a_stall) {
  Waiting waiting(60);
  CHECK_NEAR(waiting.run(1, 1000, 0.01, 30, 3600), 59, 0.2);  // of the hour that the clock jumps, one second counts
  CHECK(waiting.run(1, 59, 0.01, 0.02, 1e7) == -1);
  CHECK(has((waiting.run(1, 1000, 0.01, 30, 3600), waiting.text), "waited 60 s"));
  // Even with naps of seconds, on a hopelessly overloaded machine, the wait ends.
  Waiting slow(2);
  CHECK_NEAR(slow.run(1, 1000, 5), 25, 1);
}

TEST(a_rank_that_computes_for_long_is_waited_for_while_its_process_lives) {
  const auto run = [](bool known, double seconds, std::vector<std::string>& warnings) -> std::string {
    try {
      simulate({.ranks = 3}, [&](SimulatedRank& self) {
        Watch watch;
        if (known) watch.life = [&](int rank) { return self.alive(rank) ? lives() : gone(); };
        watch.warn = [&](const std::string& text) { warnings.push_back(text); };
        Communicator comm(self.transport(), watch);
        if (self.rank() == 0) spend(seconds);
        for (int to = 0; to < 3; ++to) comm.post(to, Phase::loads, {4, 9}, {});
        for (int from = 0; from < 3; ++from) comm.expect(from, Phase::loads, {4, 9});
        comm.finish();
      });
    } catch (const Stalled& stalled) {
      return stalled.what();
    }
    return "";
  };
  std::vector<std::string> warnings;
  CHECK(run(true, 75, warnings).empty());
  CHECK(warnings.size() == 2 &&
        has(warnings.at(0), "waited 60 s for rank 0: frame 4, phase loads; its process is alive"));
  CHECK(run(true, 5000, warnings).empty());
  warnings.clear();
  CHECK(run(false, 590, warnings).empty() && warnings.size() >= 18);
  CHECK(has(run(false, 5000, warnings), "waited 600 s for rank 0: frame 4, phase loads (it is unknown whether"));
}

TEST(a_flush_names_the_rank_that_takes_nothing) {
  Simulation simulation;
  int stalled = 0;
  for (simulation.seed = 0; simulation.seed < 30; ++simulation.seed) {
    try {
      simulate(simulation, [](SimulatedRank& self) {
        Communicator comm(self.transport(), {});
        if (self.rank() == 0) {
          comm.post(1, Phase::records, {}, {});
          comm.flush();
        } else {
          spend(1000);
          comm.expect(0, Phase::records, {});
        }
      });
    } catch (const Stalled& error) {
      CHECK(error.rank() == 1 && has(error.what(), "rank 0 waited 600 s for rank 1: delivery of its messages"));
      ++stalled;
    }
  }
  CHECK(stalled > 3 && stalled < 27);  // small messages leave at once, as MPI's do
}

}  // namespace motes::test_wait
