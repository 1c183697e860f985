// What ranks tell each other before particles are written to files: totals reach every rank, notes the manager alone,
// in any order of events; and a rank that cannot write, or writes something else, is known to all.
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "check.h"
#include "comm/simulated_ranks.h"
#include "frame/engine.h"

namespace motes::test_notes_of_ranks {
using comm::SimulatedRank;

namespace {

struct Run {
  int ranks = 1;
  bool shared = true;
  int fan_out = 8;
  std::uint64_t seed = 0;
  int failing = -1;    // the rank whose disk is full at the second write
  int differing = -1;  // the rank that writes something else then
};

struct End {
  std::vector<frame::Notes> heard;
  std::string own, why;
  int blamed = -1;
  bool manages = false;
};

frame::Note note_of(int rank, std::size_t write) {
  const auto place = static_cast<std::int64_t>(write);
  return {{rank, 1, place}, std::string(static_cast<std::size_t>(rank % 4), 'x') + std::to_string(rank)};
}

void play(SimulatedRank& self, const Run& run, End& end) {
  frame::Settings settings;
  settings.fan_out = run.fan_out;
  const roles::Cast cast = run.shared ? roles::cast_shared(run.ranks) : roles::cast_auto(run.ranks);
  frame::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), cast, settings);
  recording::SystemDefinition definition;
  definition.name = "sparks";
  engine.add_system(definition);
  end.manages = engine.talk().manages();
  try {
    engine.start();
    for (std::size_t write = 0; write < 3; ++write) {
      engine.record(0, actions::Action{actions::Kind::gravity, {0, -1, 0}, {}});
      const bool reads = write != 1;  // otherwise what was recorded waits
      const std::string what = write == 1 && self.rank() == run.differing ? "ages" : "all";
      end.heard.push_back(engine.prepare_write(what, reads, [&] {
        if (write == 1 && self.rank() == run.failing) throw std::logic_error("disk full");
        return note_of(self.rank(), write);
      }));
      engine.run_frame(std::nullopt);
    }
    engine.finish();
  } catch (const std::logic_error& error) {
    end.own = error.what();
  } catch (const frame::Agreed& agreed) {
    end.blamed = agreed.verdict().failed_rank;
    end.why = agreed.what();
  }
}

std::vector<End> ends_of(const Run& run) {
  comm::Simulation simulation;
  simulation.ranks = run.ranks;
  simulation.seed = run.seed;
  std::vector<End> ends(static_cast<std::size_t>(run.ranks));
  comm::simulate(simulation,
                 [&](SimulatedRank& self) { play(self, run, ends[static_cast<std::size_t>(self.rank())]); });
  return ends;
}

Run random_run(std::uint64_t seed) {
  Run run;
  run.seed = seed;
  run.ranks = 1 + static_cast<int>(seed % 13);
  run.shared = seed % 2 == 0;
  run.fan_out = 1 + static_cast<int>(seed % 3);
  return run;
}

}  // namespace

TEST(totals_reach_every_rank_and_notes_the_manager_alone) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Run run = random_run(seed);
    for (const End& end : ends_of(run)) {
      CHECK(end.heard.size() == 3 && end.own.empty() && end.blamed == -1);
      for (std::size_t write = 0; write < end.heard.size(); ++write) {
        const std::int64_t n = run.ranks;
        CHECK((end.heard[write].totals == std::vector<std::int64_t>{n * (n - 1) / 2, n, n * std::int64_t(write)}));
        std::vector<std::string> texts;
        for (int rank = 0; end.manages && rank < run.ranks; ++rank) texts.push_back(note_of(rank, write).text);
        CHECK(end.heard[write].texts == texts);
      }
    }
  }
}

TEST(a_rank_that_cannot_write_is_blamed_on_all_ranks) {
  for (std::uint64_t seed = 1; seed < 40; ++seed) {
    Run run = random_run(seed);
    run.failing = static_cast<int>(seed * 7) % run.ranks;
    const std::vector<End> ends = ends_of(run);
    for (int rank = 0; rank < run.ranks; ++rank) {
      const End& end = ends[static_cast<std::size_t>(rank)];
      CHECK(end.heard.size() == 1);
      CHECK(rank == run.failing ? end.own == "disk full" : end.blamed == run.failing && end.own.empty());
    }
  }
}

TEST(a_rank_that_writes_something_else_is_found_out) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Run run = random_run(seed);
    if (run.ranks < 3) continue;  // of two nobody knows who is right
    run.differing = static_cast<int>(seed * 5) % run.ranks;
    for (const End& end : ends_of(run)) {
      CHECK(end.heard.size() == 1 && end.blamed == run.differing);
      CHECK(end.why.find("different arguments: ") != std::string::npos);
    }
  }
}

}  // namespace motes::test_notes_of_ranks
