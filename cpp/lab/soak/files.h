// Damaged files: scenes, checkpoints and logs with flipped bits, lost or repeated bytes. Reading one gives an error or
// what was written, and touches no foreign memory (`.ci/asan python -m motes soak files`).
#pragma once

#include <cstdint>
#include <string>

namespace motes::soak {

struct DamagedFile {
  enum class Kind : std::uint8_t { scene, part, state, table };
  Kind kind = Kind::scene;
  bool read = false;   // read without an error, since the damage changed nothing that matters
  std::string broken;  // the promise that was broken; empty: none
};

/// Damages a file and reads it. `directory`: where a file may be written.
DamagedFile damaged_file(std::uint64_t seed, const std::string& directory);

}  // namespace motes::soak
