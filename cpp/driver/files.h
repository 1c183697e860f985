// Files of the driver: read as they lie, written whole or not at all.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace motes::driver {

/// A file as memory: ranks of one host share its pages.
class MappedFile {
 public:
  /// Throws std::runtime_error where it cannot be read.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Writes under a temporary name, syncs, renames: the file appears whole or not at all. Makes its directory. Throws
/// std::runtime_error.
void write_whole(const std::string& path, std::span<const std::byte> content);

/// A picture as PPM (binary, P6): a header of text, then the pixels, 3 bytes each, rows from the top. ffmpeg,
/// ImageMagick, Pillow and GIMP read it, and it takes no library to write.
void write_ppm(const std::string& path, int width, int height, std::span<const unsigned char> pixels);

}  // namespace motes::driver
