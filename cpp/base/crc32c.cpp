#include "base/crc32c.h"

#include <array>
#include <bit>
#include <cstring>

#if defined(__x86_64__)
#include <nmmintrin.h>
#endif

namespace motes::base {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::uint32_t kPolynomial = 0x82F63B78u;  // bits in reverse order

// tables[k][b]: the contribution of byte b to the checksum when k zero bytes follow it.
using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr Tables make_tables() {
  Tables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t sum = byte;
    for (int bit = 0; bit < 8; ++bit) sum = (sum & 1) != 0 ? sum >> 1 ^ kPolynomial : sum >> 1;
    tables[0][byte] = sum;
  }
  for (std::size_t k = 1; k < tables.size(); ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t sum = tables[k - 1][byte];
      tables[k][byte] = sum >> 8 ^ tables[0][sum & 255];
    }
  }
  return tables;
}

constexpr Tables kTables = make_tables();

std::uint32_t byte_by_byte(std::span<const std::byte> bytes, std::uint32_t sum) {
  for (const std::byte b : bytes) sum = sum >> 8 ^ kTables[0][(sum ^ static_cast<std::uint32_t>(b)) & 255];
  return sum;
}

std::uint64_t word(const std::byte* at) {
  std::uint64_t value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

#if defined(__x86_64__)

// The instruction takes three cycles and can start in each cycle, so three stretches are summed in parallel. Appending
// zero bytes changes a checksum linearly in its bits: `Shift` holds the result for each value of each of its four
// bytes.
constexpr std::size_t kStretch = 4096;

using Shift = std::array<std::array<std::uint32_t, 256>, 4>;

Shift make_shift(std::size_t zeros) {
  std::array<std::uint32_t, 32> of_bit{};
  for (std::size_t bit = 0; bit < 32; ++bit) {
    std::uint32_t sum = 1u << bit;
    for (std::size_t i = 0; i < zeros; ++i) sum = sum >> 8 ^ kTables[0][sum & 255];
    of_bit[bit] = sum;
  }
  Shift shift{};
  for (std::size_t byte = 0; byte < 4; ++byte) {
    for (std::size_t value = 0; value < 256; ++value) {
      for (std::size_t bit = 0; bit < 8; ++bit) {
        if ((value >> bit & 1) != 0) shift[byte][value] ^= of_bit[8 * byte + bit];
      }
    }
  }
  return shift;
}

std::uint32_t shifted(const Shift& shift, std::uint32_t sum) {
  return shift[0][sum & 255] ^ shift[1][sum >> 8 & 255] ^ shift[2][sum >> 16 & 255] ^ shift[3][sum >> 24];
}

__attribute__((target("sse4.2"))) std::uint32_t by_instruction(std::span<const std::byte> bytes, std::uint32_t sum) {
  static const Shift kOne = make_shift(kStretch);
  std::size_t at = 0;
  for (; bytes.size() - at >= 3 * kStretch; at += 3 * kStretch) {
    std::uint64_t a = sum, b = 0, c = 0;
    const std::byte* first = bytes.data() + at;
    for (std::size_t i = 0; i < kStretch; i += sizeof(std::uint64_t)) {
      a = _mm_crc32_u64(a, word(first + i));
      b = _mm_crc32_u64(b, word(first + kStretch + i));
      c = _mm_crc32_u64(c, word(first + 2 * kStretch + i));
    }
    sum = shifted(kOne, static_cast<std::uint32_t>(a)) ^ static_cast<std::uint32_t>(b);
    sum = shifted(kOne, sum) ^ static_cast<std::uint32_t>(c);
  }
  for (; bytes.size() - at >= sizeof(std::uint64_t); at += sizeof(std::uint64_t)) {
    sum = static_cast<std::uint32_t>(_mm_crc32_u64(sum, word(bytes.data() + at)));
  }
  return byte_by_byte(bytes.subspan(at), sum);
}

#endif

}  // namespace

std::uint32_t crc32c_by_tables(std::span<const std::byte> bytes, std::uint32_t before) {
  std::uint32_t sum = ~before;
  std::size_t at = 0;
  for (; bytes.size() - at >= 8; at += 8) {
    const std::uint64_t w = word(bytes.data() + at) ^ sum;
    sum = 0;
    for (std::size_t byte = 0; byte < 8; ++byte) sum ^= kTables[7 - byte][w >> (8 * byte) & 255];
  }
  return ~byte_by_byte(bytes.subspan(at), sum);
}

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) {
#if defined(__x86_64__)
  static const bool kInstruction = __builtin_cpu_supports("sse4.2");
  if (kInstruction) return ~by_instruction(bytes, ~before);
#endif
  return crc32c_by_tables(bytes, before);
}

}  // namespace motes::base
