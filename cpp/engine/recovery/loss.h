// A loss of ranks as the script's side of each remaining rank sees it.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "comm/wait.h"
#include "image/scene.h"
#include "roles/cast.h"

namespace motes::engine {

/// Ranks were lost, and there is no way back to what they held. The same on all ranks that are left.
class Unrecoverable : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What changed for the remaining ranks.
struct Loss {
  std::vector<int> survivors;  // the old rank of each, ascending
  std::vector<int> lost;       // old ranks
  roles::Cast before, now;     // each in the ranks of its time
  int handle = -1;             // see Communicator::handle
};

/// Every function may be empty, and may throw RankLost; whatever else `resumed` and `redrawn` throw ends the run.
struct Bystander {
  /// Collective: finds the others again. Returns why this rank cannot go on, or nothing.
  std::function<std::string(const Loss&)> regroup;
  /// The first frame of which this rank, who makes pictures now, needs the picture again; UINT64_MAX: none.
  std::function<std::uint64_t(const Loss&)> unsaved_from;
  /// The world is what it was before this frame; frames from here on run again.
  std::function<void(std::uint64_t frame)> resumed;
  /// The image generator has made the picture of a frame again.
  std::function<void(std::uint64_t frame, const image::View& view)> redrawn;
  /// How the remaining ranks watch each other while waiting; empty functions: as before.
  comm::Watch watch;
};

}  // namespace motes::engine
