// A story played by simulated ranks, with what happens to them on the way.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "comm/simulated_ranks.h"
#include "soak/story.h"

namespace motes::soak {

/// What comes out: a line per frame, from any of the ranks.
struct Film {
  std::map<std::uint64_t, std::string> particles, pictures;
  std::vector<std::string> reel;  // pictures that are in the film's file: these are not lost with a rank
};

/// What is on the disk, whatever happens to the ranks.
struct Saved {
  std::uint32_t calculators = 0;
  base::Bytes shared;
  std::map<int, base::Bytes> parts;  // files, by calculator
  std::size_t reel = 0;                   // pictures in the film
};

struct Disk {
  std::map<std::uint64_t, Saved> checkpoints;  // by frame; the newest two
};

struct Played {
  std::uint32_t losses = 0;        // that were survived
  std::uint64_t points = 0;        // see SimulatedRun
  std::vector<int> dead;
  std::string end;                 // how it ended before its end, or empty
  std::string broken;              // which promise was not kept, or empty
  std::map<std::pair<std::uint64_t, std::uint32_t>, Saved> drafts;  // checkpoints under way, by frame and losses
  std::map<std::uint64_t, std::string> orders;  // what all that came to the end heard in each frame
};

/// What happens.
struct Accidents {
  std::uint64_t order = 0;  // of events
  std::vector<comm::Simulation::Death> deaths;  // survived
  std::uint64_t killed_at = UINT64_MAX;         // the whole job, in this frame
};

/// Plays the story, from the newest checkpoint that is whole where there is a disk, to its end or that of the job. A
/// frame that comes out twice must come out alike.
Played play(const Story& story, const Way& way, const Accidents& accidents, Film& film, Disk* disk = nullptr);

}  // namespace motes::soak
