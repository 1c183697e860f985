// Parts on their way to disk, in a thread of their own, while frames go on.
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

/// Bytes that are written at once; a full disk is noticed between two of these.
inline constexpr std::size_t kPiece = std::size_t{4} << 20;

/// Writes a file under another name, brings it to the disk and gives it its name. Throws std::runtime_error, naming
/// path and reason; then no file is left.
void write_whole(const std::string& path, std::span<const std::byte> head, std::span<const std::byte> rest);

/// Writes one part at a time.
class Writer {
 public:
  Writer() = default;
  /// Waits for what is being written.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Memory for the next planes, used again from part to part. Waits for the part before.
  base::Bytes& planes();

  /// Starts to write what stands in planes().
  void write(std::string path, Description description);

  /// Waits until all is written.
  void wait();
  bool busy() const;

  /// How the last part that was begun went: `written` is the newest frame of which the part is on disk.
  struct Outcome {
    std::optional<std::uint64_t> written{};
    std::string error{};  // of the last one
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
