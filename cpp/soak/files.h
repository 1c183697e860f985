// Files that something has damaged: scenes, checkpoints and logs with bits flipped, bytes lost or doubled. Reading one
// gives an error or what was written, and touches no memory but its own (`.ci/asan python -m motes soak files`).
#pragma once

#include <cstdint>
#include <string>

namespace motes::soak {

struct DamagedFile {
  enum class Kind : std::uint8_t { scene, part, state, table };
  Kind kind = Kind::scene;
  bool read = false;   // all the same, because the damage concerns nothing that counts
  std::string broken;  // what was read is not what was written; or empty
};

/// `directory`: where a file may be written.
DamagedFile damaged_file(std::uint64_t seed, const std::string& directory);

}  // namespace motes::soak
