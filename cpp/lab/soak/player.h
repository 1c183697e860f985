// Plays a story on simulated ranks, with accidents on the way.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "comm/simulated_ranks.h"
#include "lab/soak/story.h"

namespace motes::soak {

/// The output of a run: a line per frame, from any of the ranks.
struct Film {
  std::map<std::uint64_t, std::string> particles, pictures;
  std::vector<std::string> reel;  // pictures in the film's file, which are not lost with a rank
};

/// A checkpoint on disk, which survives the loss of ranks.
struct Saved {
  std::uint32_t calculators = 0;
  base::Bytes shared;
  std::map<int, base::Bytes> parts;  // files, by calculator
  std::size_t reel = 0;  // pictures in the film
};

struct Disk {
  std::map<std::uint64_t, Saved> checkpoints;  // by frame; the newest two
};

struct Played {
  std::uint32_t losses = 0;        // survived by the run
  std::uint64_t points = 0;        // see SimulatedRun
  std::vector<int> dead;
  std::string end;  // why the run ended early, or empty
  std::string broken;  // the promise that was broken, or empty
  std::map<std::pair<std::uint64_t, std::uint32_t>, Saved> drafts;  // unfinished checkpoints, by frame and losses
  std::map<std::uint64_t, std::string> orders;  // by frame, equal on all ranks that reached the end
};

/// The accidents of a run.
struct Accidents {
  std::uint64_t order = 0;  // seed of the order of events
  std::vector<comm::Simulation::Death> deaths;  // of single ranks, which the run survives
  std::uint64_t killed_at = UINT64_MAX;  // frame in which the whole job is killed
};

/// Plays the story to its end or to that of the job, from the newest whole checkpoint if there is a disk. A frame that
/// comes out twice must be the same.
Played play(const Story& story, const Way& way, const Accidents& accidents, Film& film, Disk* disk = nullptr);

}  // namespace motes::soak
