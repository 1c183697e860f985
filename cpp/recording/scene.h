// A scene as a file: the recorded lists of all its frames, which the native driver replays without Python.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "recording/record.h"

namespace motes::recording {

struct Scene {
  std::string version;  // of motes when it was recorded
  std::vector<std::pair<std::string, std::string>> facts;  // without effect on particles: script, roles, balancer, ...
  std::vector<std::span<const std::byte>> frames;  // one record each, in order; the caller owns the bytes

  /// Returns the fact with this name, or an empty string.
  std::string fact(const std::string& name) const;
};

/// Writes the file: magic, schema, length, fingerprint of the lists' layout, hash, then the scene, and the pictures and
/// meshes that its frames name, which this process must keep. The version of `scene` is ignored: the file gets the
/// version of this build. Throws std::runtime_error if a frame is not a record.
void write(const Scene& scene, base::Bytes& out);

/// Reads a scene, whose frames point into `bytes`. From then on this process keeps the scene's pictures and meshes.
/// Throws std::runtime_error naming what is wrong if the bytes are not a scene, cut off, damaged, or recorded by a
/// version with different lists.
Scene read_scene(std::span<const std::byte> bytes);

/// Reads one frame's record, and checks it against what scripts may record. Throws std::runtime_error or
/// std::invalid_argument.
Record read_frame(std::span<const std::byte> bytes);

/// Returns the version of motes, as in pyproject.toml.
const char* version();

}  // namespace motes::recording
