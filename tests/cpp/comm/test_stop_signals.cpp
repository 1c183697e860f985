// Signals that ask for a stop: what a process records of them, and how ranks agree on the frame after which they stop.
#include "comm/stop_signals.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <map>
#include <memory>

#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"
#include "support/falling_source.h"

namespace motes::test_stop_signals {
using comm::SimulatedRank;

namespace {

// Returns how a child process ends: its exit code, or minus the signal.
template <class Work>
int child(const Work& work) {
  const pid_t process = fork();
  if (process == 0) {
    work();
    exit(0);
  }
  int status = 0;
  waitpid(process, &status, 0);
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

TEST(the_first_signal_is_noted_and_a_second_one_does_what_it_did_before) {
  CHECK(child([] {
          comm::note_stop_signals({SIGINT, SIGTERM, SIGUSR1}, 0, false);
          raise(SIGUSR1);
          raise(SIGUSR1);
          raise(SIGTERM);  // the first that is urgent
          _exit(comm::stop_signal());
        }) == SIGUSR1);
  CHECK(child([] {
          comm::note_stop_signals({SIGINT, SIGTERM}, 0, false);
          raise(SIGINT);
          raise(SIGTERM);
        }) == -SIGTERM);
  CHECK(child([] {
          comm::note_stop_signals({SIGTERM}, 60, false);
          raise(SIGTERM);
          raise(SIGTERM);  // the same signal, passed on by two processes
          _exit(comm::stop_signal());
        }) == SIGTERM);
}

TEST(signals_that_are_not_asked_for_or_released_are_left_alone) {
  CHECK(child([] {
          comm::note_stop_signals({SIGINT}, 0, false);
          raise(SIGTERM);
        }) == -SIGTERM);
  CHECK(child([] {
          comm::note_stop_signals({SIGTERM}, 0, false);
          comm::release_stop_signals();
          raise(SIGTERM);
        }) == -SIGTERM);
  CHECK(child([] {
          comm::note_stop_signals({SIGTERM}, 0, false);
          signal(SIGTERM, SIG_IGN);  // the script's own
          comm::release_stop_signals();
          raise(SIGTERM);
          _exit(7 + comm::stop_signal());
        }) == 7);
  CHECK(child([] {
          comm::note_stop_signals({SIGTERM}, 0, false);
          raise(SIGTERM);
          comm::forget_stop_signal();
          raise(SIGTERM);
          _exit(comm::stop_signal());
        }) == SIGTERM);
}

TEST(a_child_of_a_process_that_notes_signals_ends_by_its_first) {
  CHECK(child([] {
          comm::note_stop_signals({SIGTERM}, 0, false);
          _exit(child([] { raise(SIGTERM); }) == -SIGTERM ? 5 : 6);
        }) == 5);
}

TEST(an_exit_code_replaces_0_only) {
  CHECK(child([] { comm::end_with_code(143); }) == 143);
  CHECK(child([] {
          comm::end_with_code(143);
          exit(3);
        }) == 3);
}

namespace {

struct Asked {
  int ranks = 1;
  bool shared = false;
  int fan_out = 8;
  engine::Combine combine = engine::Combine::together;
  std::map<int, std::pair<std::uint64_t, int>> signals;  // by rank: the frame in which it gets a signal, and its number
};

// After how many frames each rank stops, and because of which signal.
using Stops = std::map<int, std::pair<std::uint64_t, int>>;

void play(SimulatedRank& self, const Asked& asked, Stops& stops) {
  const roles::Cast cast = asked.shared ? roles::cast_shared(asked.ranks) : roles::cast_auto(asked.ranks);
  engine::Settings settings;
  settings.costs.act.fill(1000);
  settings.fan_out = asked.fan_out;
  settings.combine = asked.combine;
  engine::Engine* engine_of_rank = nullptr;
  settings.stop_signal = [&] {
    const auto signal = asked.signals.find(self.rank());
    return signal != asked.signals.end() && engine_of_rank->frame() >= signal->second.first ? signal->second.second : 0;
  };
  engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), cast, settings);
  engine_of_rank = &engine;
  recording::SystemDefinition definition;
  definition.space = {domains::Space::Kind::finite, -4, 4};
  for (const char* name : {"a", "b"}) {
    definition.name = name;
    engine.add_system(definition);
  }
  engine.start();
  CHECK(engine.stop_asked() == 0);
  while (engine.stop_asked() == 0 && engine.frame() < 9) {
    for (int system = 0; system < 2; ++system) {
      engine.record(system, test::falling_source(20));
      engine.record(system, actions::make(actions::numbers::move<>{.rotational = 1}));
    }
    engine.run_frame(std::nullopt);
    const int before = engine.stop_asked();
    engine.gather(0, true);
    engine.digest();
    CHECK(engine.stop_asked() == before);  // reads do not stop
  }
  stops[self.rank()] = {engine.frame(), engine.stop_asked()};
  engine.finish();
}

}  // namespace

TEST(all_ranks_stop_after_the_same_frame_whoever_got_the_signal) {
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    Asked asked;
    asked.ranks = 1 + static_cast<int>(seed % 9);
    asked.shared = seed % 2 == 0;
    asked.fan_out = 1 + static_cast<int>(seed % 3);
    asked.combine = static_cast<engine::Combine>(seed / 2 % 3);
    const std::uint64_t in_frame = seed % 5;
    const int first = static_cast<int>(seed * 7) % asked.ranks;
    asked.signals[first] = {in_frame, SIGTERM};
    if (seed % 4 == 0) asked.signals[(first + 1) % asked.ranks] = {in_frame, SIGINT};  // the highest number counts
    if (seed % 4 == 1) asked.signals[(first + 2) % asked.ranks] = {in_frame + 1, SIGINT};  // comes too late
    if (asked.ranks <= 2) asked.signals = {{first, {in_frame, SIGTERM}}};
    Stops stops;
    for (int rank = 0; rank < asked.ranks; ++rank) stops[rank] = {};
    comm::simulate({.ranks = asked.ranks, .seed = seed}, [&](SimulatedRank& self) { play(self, asked, stops); });
    for (const auto& [rank, stop] : stops) CHECK(stop == std::pair(in_frame + 1, SIGTERM));
  }
}

TEST(ranks_without_a_signal_go_on) {
  Stops stops = {{0, {}}, {1, {}}, {2, {}}};
  comm::simulate({.ranks = 3},
                 [&](SimulatedRank& self) { play(self, {3, false, 8, engine::Combine::together, {}}, stops); });
  for (const auto& [rank, stop] : stops) CHECK(stop == std::pair(std::uint64_t{9}, 0));
}

}  // namespace motes::test_stop_signals
