// The loss of ranks, as seen by the callers of the engine on the remaining ranks.
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

/// Ranks were lost and their particles cannot be restored. Thrown on all remaining ranks.
class Unrecoverable : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The changes for the remaining ranks.
struct Loss {
  std::vector<int> survivors;  // old rank numbers of the remaining ranks, ascending
  std::vector<int> lost;       // old rank numbers of the lost ranks
  roles::Cast before, now;     // `before` with old rank numbers, `now` with new ones
  int handle = -1;             // see Communicator::handle
};

/// Callbacks for recovery. Each may be empty and may throw RankLost; any other exception from `resumed` or `redrawn`
/// ends the run.
struct Bystander {
  /// Adapts to the new ranks. Returns why this rank cannot continue, or an empty string. Collective.
  std::function<std::string(const Loss&)> regroup;
  /// Returns the first frame whose picture this rank, the new image generator, needs again; UINT64_MAX: none.
  std::function<std::uint64_t(const Loss&)> unsaved_from;
  /// Called when the world is restored to its state before this frame; frames from here on run again.
  std::function<void(std::uint64_t frame)> resumed;
  /// Image generator: called when the picture of a frame has been drawn again.
  std::function<void(std::uint64_t frame, const image::View& view)> redrawn;
  /// How the remaining ranks watch each other while waiting; empty functions: as before.
  comm::Watch watch;
};

}  // namespace motes::engine
