// The seconds of frames in the log, on simulated ranks whose clocks are exact.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "comm/clock.h"
#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"

namespace motes::test_frame_seconds {
using comm::SimulatedRank;

namespace {

constexpr int kFrames = 12;

// A new directory, removed at its end.
struct Folder {
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "motes_seconds_XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path); }

  std::filesystem::path path;
};

double field(const std::string& line, const std::string& name) {
  return std::stod(line.substr(line.find("\"" + name + "\":") + name.size() + 3));
}

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

struct Run {
  std::vector<double> frames_s;      // t_frame_s of each frame
  std::map<int, double> walls_s;     // sum of wall_s, by rank
  double longest_s = 0;              // sum of the longest wall_s of each frame
  double took_s = 0;                 // from the first rank's start to the last rank's end, without pauses
};

image::View view() {
  image::View view;
  view.width = 32;
  view.height = 32;
  view.camera.position = {0, 1, 8};
  return view;
}

// Runs frames in which one rank after another sleeps; with `pauses`, the ranks also pause before every third frame.
Run run(int ranks, bool pauses) {
  const Folder folder;
  std::vector<double> starts(static_cast<std::size_t>(ranks), 0), ends = starts, paused = starts;
  comm::simulate({.ranks = ranks, .variation = 0}, [&](SimulatedRank& self) {
    const auto rank = static_cast<std::size_t>(self.rank());
    engine::Settings settings;
    settings.costs.picture = 5e7;  // the image generator ends every other frame 50 ms later than the others
    settings.log.directory = folder.path.string();
    settings.log.hosts.assign(static_cast<std::size_t>(ranks), "h");
    auto communicator = std::make_unique<comm::Communicator>(self.transport(), comm::Watch{});
    engine::Engine engine(std::move(communicator), roles::cast_shared(ranks), settings);
    recording::SystemDefinition definition;
    definition.name = "s";
    definition.space = {domains::Space::Kind::finite, -1, 1};
    engine.add_system(definition);
    starts[rank] = comm::wall_seconds();
    engine.start();
    for (int frame = 0; frame < kFrames; ++frame) {
      if (frame % ranks == self.rank()) comm::spend(0.01);
      engine.run_frame(frame % 2 == 0 ? std::optional(view()) : std::nullopt);
      ends[rank] = comm::wall_seconds();
      if (!pauses || frame % 3 != 2 || frame + 1 == kFrames) continue;
      comm::spend(1 + self.rank());
      engine.hear_orders("pause");
    }
    engine.finish();
  });
  Run run;
  std::map<int, double> longest;
  for (const std::string& line : lines_of(folder.path / "frames.jsonl")) {
    run.frames_s.push_back(field(line, "t_frame_s"));
  }
  for (const std::string& line : lines_of(folder.path / "times.jsonl")) {
    const double wall_s = field(line, "wall_s");
    run.walls_s[static_cast<int>(field(line, "rank"))] += wall_s;
    double& frame_s = longest[static_cast<int>(field(line, "frame"))];
    frame_s = std::max(frame_s, wall_s);
  }
  for (const auto& [frame, seconds] : longest) run.longest_s += seconds;
  run.took_s = *std::max_element(ends.begin(), ends.end()) - *std::min_element(starts.begin(), starts.end());
  return run;
}

double sum(const std::vector<double>& seconds) {
  double all = 0;
  for (const double one : seconds) all += one;
  return all;
}

}  // namespace

TEST(seconds_of_frames_add_up_to_the_run) {
  for (const int ranks : {1, 2, 3, 5}) {
    const Run of = run(ranks, false);
    CHECK(of.frames_s.size() == kFrames);
    CHECK(*std::min_element(of.frames_s.begin(), of.frames_s.end()) > 0);
    double longest = 0;
    for (const auto& [rank, seconds] : of.walls_s) longest = std::max(longest, seconds);
    CHECK_NEAR(sum(of.frames_s), longest, 1e-6);
    CHECK_NEAR(sum(of.frames_s), of.took_s, 1e-3);  // ranks start within messages' latency
    if (ranks > 2) CHECK(of.longest_s > 1.1 * of.took_s);  // what the sum of each frame's longest rank would say
  }
}

TEST(seconds_of_frames_leave_out_pauses) {
  for (const int ranks : {1, 3, 5}) {
    const double with = sum(run(ranks, true).frames_s), without = sum(run(ranks, false).frames_s);
    CHECK(with > without - 1e-3);
    CHECK_NEAR(with, without, 0.16);  // ranks wait for each other at a pause, so none runs ahead
  }
}

}  // namespace motes::test_frame_seconds
