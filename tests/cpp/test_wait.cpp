// When a wait warns and when it gives up, with a clock that the test controls.
#include <string>
#include <vector>

#include "check.h"
#include "comm/clock.h"
#include "comm/communicator.h"
#include "comm/simulated_ranks.h"
#include "comm/wait.h"

using namespace motes::comm;

namespace {

// Rank 1 waits for rank 3; the clock moves one nap at a time until the wait ends.
struct Waiting {
  explicit Waiting(double stall_s) {
    watch.stall_s = stall_s;
    watch.warn = [this](const std::string& text) { warnings.push_back(text); };
    watch.while_waiting = [this](int rank) { looks.push_back(rank); };
  }

  // Seconds until Stalled, or -1: not within `at_most_s`. From `jump_at_s` on the clock is `jump_s` ahead.
  double run(double limits, double at_most_s, double nap_s = 0.01, double jump_at_s = 1e9, double jump_s = 0) {
    Wait wait(watch, 1, "frame 7, phase report", limits, 100);
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

TEST(a_wait_ends_at_the_stall_limit_where_nobody_knows_of_the_process) {
  Waiting waiting(60);
  CHECK_NEAR(waiting.run(1, 1000), 60, 0.1);
  CHECK(waiting.text ==
        "rank 1 waited 60 s for rank 3: frame 7, phase report (MOTES_STALL_S, now 60 s, sets the limit)");
  CHECK(waiting.warnings.empty());
  CHECK(waiting.looks.size() > 900 && waiting.looks.size() <= 1200);  // every 50 ms
  CHECK_NEAR(waiting.run(1.5, 1000), 90, 0.1);
}

TEST(a_wait_ends_at_the_stall_limit_where_the_process_is_gone) {
  Waiting waiting(60);
  waiting.watch.alive = [](int) { return false; };
  waiting.watch.describe = [](int rank) { return rank == 3 ? "rank 3 (calculator 1)" : "rank 1 (manager)"; };
  CHECK_NEAR(waiting.run(1, 1000), 60, 0.1);
  CHECK(
      has(waiting.text, "rank 1 (manager) waited 60 s for rank 3 (calculator 1): frame 7, phase report (its process"));
  CHECK(has(waiting.text, "is gone, or on another host; MOTES_STALL_S"));
  CHECK(waiting.warnings.empty());
}

TEST(a_wait_for_a_living_process_warns_once_and_goes_on_to_ten_limits) {
  Waiting waiting(6);
  waiting.watch.alive = [](int rank) { return rank == 3; };
  CHECK_NEAR(waiting.run(1.25, 1000), 75, 0.1);
  CHECK(waiting.warnings.size() == 1);
  CHECK(has(waiting.warnings.at(0),
            "rank 1 waited 7 s for rank 3: frame 7, phase report (its process lives, so it goes "
            "on waiting, for 75 s in all; MOTES_STALL_S, now 6 s, sets the limit)"));
  CHECK(has(waiting.text, "waited 75 s for rank 3: frame 7, phase report (its process lives; MOTES_STALL_S"));
}

TEST(a_wait_ends_when_the_process_dies_after_the_warning) {
  Waiting waiting(6);
  bool lives = true;
  waiting.watch.alive = [&](int) { return lives; };
  waiting.watch.while_waiting = [&](int) { lives = waiting.warnings.empty(); };
  CHECK_NEAR(waiting.run(1, 1000), 6, 0.2);
  CHECK(waiting.warnings.size() == 1 && has(waiting.text, "is gone"));
}

TEST(a_suspended_process_does_not_count_the_time_as_a_stall) {
  Waiting waiting(60);
  CHECK_NEAR(waiting.run(1, 1000, 0.01, 30, 3600), 59, 0.2);  // of the hour, one second counts
  CHECK(waiting.run(1, 59, 0.01, 0.02, 1e7) == -1);
  CHECK(has((waiting.run(1, 1000, 0.01, 30, 3600), waiting.text), "waited 60 s"));
  // Even naps of seconds, on a hopelessly overloaded machine, come to an end.
  Waiting slow(2);
  CHECK_NEAR(slow.run(1, 1000, 5), 25, 1);
}

TEST(a_rank_that_computes_for_long_is_waited_for_while_its_process_lives) {
  const auto run = [](bool known, double seconds, std::vector<std::string>& warnings) -> std::string {
    Simulation simulation;
    simulation.ranks = 3;
    try {
      simulate(simulation, [&](SimulatedRank& self) {
        Watch watch;
        watch.stall_s = 60;
        if (known) watch.alive = [&](int rank) { return self.alive(rank); };
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
  CHECK(warnings.size() == 2 && has(warnings.at(0), "waited 60 s for rank 0: frame 4, phase loads"));
  warnings.clear();
  CHECK(run(true, 599, warnings).empty());
  CHECK(has(run(true, 601, warnings), "waited 600 s for rank 0"));
  warnings.clear();
  CHECK(has(run(false, 75, warnings), "waited 60 s for rank 0: frame 4, phase loads (MOTES_STALL_S"));
  CHECK(warnings.empty());
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
          spend(100);
          comm.expect(0, Phase::records, {});
        }
      });
    } catch (const Stalled& error) {
      CHECK(error.rank() == 1 && has(error.what(), "rank 0 waited 60 s for rank 1: to take its messages"));
      ++stalled;
    }
  }
  CHECK(stalled > 3 && stalled < 27);  // small messages leave at once, as MPI's do
}
