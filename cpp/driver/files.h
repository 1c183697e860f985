// Files of the driver: mapped when read, written completely or not at all.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace motes::driver {

/// A file mapped into memory: ranks on one host share its pages.
class MappedFile {
 public:
  /// Maps a file. Throws std::runtime_error if it cannot be read.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Writes a file under a temporary name, syncs and renames it: it appears complete or not at all. Creates its
/// directory. Throws std::runtime_error.
void write_whole(const std::string& path, std::span<const std::byte> content);

/// Writes a picture as PPM (binary, P6): a text header, then the pixels, 3 bytes each, rows from top to bottom. ffmpeg,
/// ImageMagick, Pillow and GIMP read it, and writing it needs no library.
void write_ppm(const std::string& path, int width, int height, std::span<const unsigned char> pixels);

}  // namespace motes::driver
