// Reads a part from disk.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "snapshots/part.h"

namespace motes::snapshots {

/// A part's file, mapped into memory: only what is used is read from disk.
class PartFile {
 public:
  /// Opens and checks a file. Throws std::runtime_error, naming the path and what is wrong, if the file cannot be read
  /// or is not whole; with `sums`, also if its planes have changed.
  PartFile(const std::string& path, bool sums);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  const Description& description() const { return opened_.description; }
  std::span<const std::byte> planes() const { return opened_.planes; }

 private:
  void* memory_ = nullptr;
  std::size_t bytes_ = 0;
  Opened opened_;
};

}  // namespace motes::snapshots
