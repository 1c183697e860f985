// Writes parts to disk in a separate thread, while the next frames run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "base/bytes.h"
#include "snapshots/part.h"

namespace motes::snapshots {

/// Bytes that are written at once; a full disk is detected between two such pieces.
inline constexpr std::size_t kPiece = std::size_t{4} << 20;

/// Writes a file under a temporary name, syncs it to disk and renames it. Throws std::runtime_error, naming path and
/// reason; then no file is left.
void write_whole(const std::string& path, std::span<const std::byte> head, std::span<const std::byte> rest);

/// Writes one part at a time.
class Writer {
 public:
  Writer() = default;
  /// Waits until the current part is written.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Returns memory for the next planes, which all parts reuse. Waits until the previous part is written.
  base::Bytes& planes();

  /// Starts to write the content of planes().
  void write(std::string path, Description description);

  /// Waits until all is written.
  void wait();
  bool busy() const;

  /// The outcome so far: `written` is the newest frame whose part is on disk.
  struct Outcome {
    std::optional<std::uint64_t> written{};
    std::string error{};  // of the last part; empty: none
  };
  Outcome outcome() const;

 private:
  void run(const std::string& path, Description description);

  mutable std::mutex mutex_;
  std::thread thread_;
  bool busy_ = false;
  Outcome outcome_;
  base::Bytes planes_;
};

}  // namespace motes::snapshots
