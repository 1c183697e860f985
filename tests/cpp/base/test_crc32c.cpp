// Checksums of checkpoints: published values, and the processor's instruction compared with tables.
#include <cstring>
#include <vector>

#include "base/crc32c.h"
#include "support/check.h"

namespace motes::test_crc32c {
using namespace base;

namespace {

std::vector<std::byte> bytes_of(const char* text) {
  const auto* first = reinterpret_cast<const std::byte*>(text);
  return {first, first + std::strlen(text)};
}

std::vector<std::byte> noise(std::size_t count) {
  std::vector<std::byte> bytes(count);
  std::uint64_t state = 88172645463325252u;
  for (std::byte& b : bytes) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    b = static_cast<std::byte>(state);
  }
  return bytes;
}

}  // namespace

// RFC 3720, appendix B.4, and the check value of the catalogue of CRCs.
TEST(crc32c_of_known_bytes) {
  CHECK(base::crc32c({}) == 0);
  CHECK(base::crc32c(bytes_of("123456789")) == 0xE3069283u);
  const std::vector<std::byte> zeros(32);
  CHECK(base::crc32c(zeros) == 0x8A9136AAu);
  const std::vector<std::byte> ones(32, std::byte{0xFF});
  CHECK(base::crc32c(ones) == 0x62A8AB43u);
  std::vector<std::byte> ascending(32);
  for (std::size_t i = 0; i < 32; ++i) ascending[i] = static_cast<std::byte>(i);
  CHECK(base::crc32c(ascending) == 0x46DD794Eu);
}

// Lengths around those at which stretches are summed in parallel, at all alignments.
TEST(crc32c_is_the_same_by_tables_and_in_parts) {
  const std::vector<std::byte> all = noise(60000);
  for (const std::size_t count : {1u, 7u, 8u, 9u, 4095u, 4096u, 12287u, 12288u, 12289u, 24576u, 24600u, 50001u}) {
    for (std::size_t first = 0; first < 9; ++first) {
      const auto bytes = std::span(all).subspan(first, count);
      const std::uint32_t sum = base::crc32c(bytes);
      CHECK(sum == base::crc32c_by_tables(bytes));
      const std::size_t cut = count / 3;
      CHECK(sum == base::crc32c(bytes.subspan(cut), base::crc32c(bytes.first(cut))));
    }
  }
}

TEST(crc32c_of_a_flipped_bit_differs) {
  std::vector<std::byte> bytes = noise(13000);
  const std::uint32_t sum = base::crc32c(bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += 41) {
    const auto mask = static_cast<std::byte>(1u << bit % 8);
    bytes[bit / 8] ^= mask;
    CHECK(base::crc32c(bytes) != sum);
    bytes[bit / 8] ^= mask;
  }
}

}  // namespace motes::test_crc32c
