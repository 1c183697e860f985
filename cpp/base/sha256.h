// SHA-256 (FIPS 180-4), for fingerprints of pictures.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace motes::base {

class Sha256 {
 public:
  void add(std::span<const std::byte> bytes);
  void add(const std::string& text) { add(std::as_bytes(std::span(text))); }

  /// Returns 64 hexadecimal digits for everything added. Nothing may be added afterwards.
  std::string finish();

 private:
  void take_block(const std::byte* block);

  std::array<std::uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                         0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::byte, 64> block_{};
  std::uint64_t size_ = 0;  // bytes so far
};

/// Returns the fingerprint that Python's Frame.digest() returns: of the text "<height>x<width>x3", a line feed, and the
/// pixels.
std::string picture_sha256(int width, int height, std::span<const std::uint8_t> pixels);

}  // namespace motes::base
