// CRC-32C (Castagnoli; RFC 3720, appendix B.4): detects bytes that a disk or a transfer has changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace motes::base {

/// Returns the checksum of bytes that may come in parts; `before` is that of the earlier parts.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0);

/// Computes the same checksum with tables, on any processor; the reference for crc32c().
std::uint32_t crc32c_by_tables(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace motes::base
