// Collective calls in the middle of a frame. Sums over the particles of many ranks are the same on every rank, whatever
// the number of ranks, their tree and the order of events. Before particles are written, totals reach every rank, and
// notes only the manager. All ranks learn when one of them fails or makes a different call.
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"

namespace motes::test_sums_of_ranks {
using actions::Op;
using comm::SimulatedRank;
using program::Sum;
using program::Totals;
using recording::Verb;

namespace {

struct Run {
  int ranks = 1;
  bool shared = true;
  int fan_out = 8;
  int substeps = 1;
  std::uint64_t seed = 0;
  int failing = -1;  // the rank whose callback throws, or that cannot write
  enum class Asks { sums, digest, gather, write } asks = Asks::sums;  // the call in which it does
  int differing = -1;  // the rank that asks for other sums, or writes something else
};

// How each rank ended: its own exception, or the rank that all blame and why.
struct End {
  std::vector<Totals> found;
  std::vector<engine::Notes> notes;
  std::string own, why;
  int blamed = -1;
  bool manages = false;
};

engine::Note note_of(int rank, int frame) {
  return {{rank, 1, frame}, std::string(static_cast<std::size_t>(rank % 4), 'x') + std::to_string(rank)};
}

actions::Expression component(int attribute, int c) {
  return {{Op::column, particles::Schema()[attribute].first_component + c, 0}};
}

Sum energy() {
  Sum sum;
  sum.weights = {component(particles::velocity, 0), component(particles::position, 2)};
  return sum;
}

Sum grid(bool weighted) {
  Sum sum;
  for (int c = 0; c < 2; ++c) sum.dimensions.push_back({component(particles::position, c), {-20, -3, 0, 4, 20}, true});
  if (weighted) sum.weights = {component(particles::velocity, 1)};
  return sum;
}

void play(SimulatedRank& self, const Run& run, End& end) {
  engine::Settings settings;
  settings.fan_out = run.fan_out;
  settings.substeps = run.substeps;
  const roles::Cast cast = run.shared ? roles::cast_shared(run.ranks) : roles::cast_auto(run.ranks);
  engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), cast, settings);
  recording::SystemDefinition definition;
  definition.name = "photons";
  definition.space = {domains::Space::Kind::finite, -10, 10};
  engine.add_system(definition);
  definition.name = "neutrons";
  engine.add_system(definition);
  end.manages = engine.session().manages();
  int frame = 0;
  engine.on_callback([&](const engine::Call&) {
    const bool fails = frame == 2 && self.rank() == run.failing && run.asks != Run::Asks::write;
    if (fails) throw std::logic_error("broken");
  });
  try {
    engine.start();
    for (; frame < 3; ++frame) {
      recording::Burst burst;
      burst.shape = {shapes::Kind::box, {-10, -3, -1, 10, 3, 1}};
      burst.count = 500;
      const actions::distributions::InShape velocity{{shapes::Kind::box, {-90, 0, 0, 90, 1, 1}}};
      burst.state = {{particles::velocity, velocity}};
      engine.record(0, burst);
      engine.record(1, burst);
      if (run.failing >= 0) engine.record(0, recording::Callback{"look", 0, {}, {}});
      engine.record(0, actions::make(actions::numbers::move<>{.rotational = 1}));
      const bool writes = frame == 2 && run.asks == Run::Asks::write;
      const bool differs = frame == 2 && self.rank() == run.differing;
      const bool reads = frame == 0;  // later, what was recorded waits for the next call
      end.notes.push_back(engine.prepare_write(writes && differs ? "ages" : "all", reads, [&] {
        if (writes && self.rank() == run.failing) throw std::logic_error("broken");
        return note_of(self.rank(), frame);
      }));
      if (frame == 2 && run.asks == Run::Asks::digest) engine.digest();
      if (frame == 2 && run.asks == Run::Asks::gather) engine.gather(0, true);
      end.found.push_back(engine.sum(0, Verb::total, energy()));  // in the middle of a frame
      end.found.push_back(engine.sum(0, Verb::tally, grid(differs)));
      engine.record(0, actions::make(actions::numbers::gravity<>{.acceleration = {0, -1, 0}}));
      engine.run_frame(std::nullopt);
      end.found.push_back(engine.sum(0, Verb::histogram, grid(true)));
    }
    engine.finish();
  } catch (const std::logic_error& error) {
    end.own = error.what();
  } catch (const engine::Agreed& agreed) {
    end.blamed = agreed.verdict().failed_rank;
    end.why = agreed.what();
  }
}

std::vector<End> ends_of(const Run& run) {
  std::vector<End> ends(static_cast<std::size_t>(run.ranks));
  comm::simulate({.ranks = run.ranks, .seed = run.seed},
                 [&](SimulatedRank& self) { play(self, run, ends[static_cast<std::size_t>(self.rank())]); });
  return ends;
}

// Returns a run with random numbers of ranks, trees and orders of events.
Run random_run(std::uint64_t seed) {
  Run run;
  run.seed = seed;
  run.ranks = 2 + static_cast<int>(seed % 12);
  run.shared = seed % 2 == 0;
  run.fan_out = 1 + static_cast<int>(seed % 3);
  return run;
}

}  // namespace

TEST(sums_are_the_same_on_all_ranks_whatever_their_number) {
  for (const int substeps : {1, 3}) {
    Run alone;
    alone.substeps = substeps;
    const End wanted = ends_of(alone)[0];
    CHECK(wanted.found.size() == 9 && std::get<std::vector<double>>(wanted.found[6])[0] != 0);
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      Run run = random_run(seed);
      run.substeps = substeps;
      for (const End& end : ends_of(run)) CHECK(end.found == wanted.found && end.own.empty() && end.blamed == -1);
    }
  }
}

TEST(totals_reach_every_rank_and_notes_the_manager_alone) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Run run = random_run(seed);
    for (const End& end : ends_of(run)) {
      CHECK(end.notes.size() == 3);
      for (int frame = 0; frame < 3; ++frame) {
        const engine::Notes& notes = end.notes[static_cast<std::size_t>(frame)];
        const std::int64_t n = run.ranks;
        CHECK((notes.totals == std::vector<std::int64_t>{n * (n - 1) / 2, n, n * frame}));
        std::vector<std::string> texts;
        for (int rank = 0; end.manages && rank < run.ranks; ++rank) texts.push_back(note_of(rank, frame).text);
        CHECK(notes.texts == texts);
      }
    }
  }
}

TEST(a_rank_that_fails_while_all_read_or_write_is_blamed_on_all_ranks) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Run run = random_run(seed);
    run.asks = static_cast<Run::Asks>(seed / 2 % 4);
    run.failing = run.ranks - 1;  // a calculator in every cast
    const std::vector<End> ends = ends_of(run);
    for (int rank = 0; rank < run.ranks; ++rank) {
      const End& end = ends[static_cast<std::size_t>(rank)];
      CHECK(end.found.size() == 6);
      CHECK(rank == run.failing ? end.own == "broken" : end.blamed == run.failing && end.own.empty());
    }
  }
}

TEST(a_rank_that_asks_for_something_else_is_found_out) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Run run = random_run(seed);
    if (run.ranks < 3) continue;  // of two ranks, neither knows which is right
    run.differing = static_cast<int>(seed * 5) % run.ranks;
    run.asks = seed % 3 == 0 ? Run::Asks::write : Run::Asks::sums;
    const bool writes = run.asks == Run::Asks::write;
    for (const End& end : ends_of(run)) {
      CHECK(end.found.size() == (writes ? 6 : 7) && end.blamed == run.differing);
      CHECK(end.why.find(writes ? "different arguments: " : "different arguments: photons, ") != std::string::npos);
    }
  }
}

}  // namespace motes::test_sums_of_ranks
