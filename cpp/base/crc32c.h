// CRC-32C (Castagnoli; RFC 3720, appendix B.4): finds out bytes that a disk or a transfer has changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace motes::base {

/// The checksum of bytes that may come in parts: `before` is that of the parts so far.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0);

/// The same by tables, on any processor: what the one above must come to.
std::uint32_t crc32c_by_tables(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace motes::base
