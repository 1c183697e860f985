// Ids of particles, stored as halves. Upper halves are 0 until a system has emitted 2^32 particles: until then they
// take no memory, and no step reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace motes::particles {

constexpr std::uint32_t lower_half(std::uint64_t id) { return static_cast<std::uint32_t>(id); }
constexpr std::uint32_t upper_half(std::uint64_t id) { return static_cast<std::uint32_t>(id >> 32); }

/// Read-only ids: a plane of lower halves and, if any upper half is not 0, a plane of upper halves.
struct Ids {
  const std::uint32_t* lower = nullptr;
  const std::uint32_t* upper = nullptr;  // null: all are 0

  Ids() = default;
  Ids(const std::uint32_t* lower_halves, const std::uint32_t* upper_halves)
      : lower(lower_halves), upper(upper_halves) {}

  std::uint64_t operator[](std::size_t i) const {
    return (upper == nullptr ? 0 : std::uint64_t{upper[i]} << 32) | lower[i];
  }

  /// Returns the ids from number `first` on.
  Ids from(std::size_t first) const { return {lower + first, upper == nullptr ? nullptr : upper + first}; }
};

/// Writes `count` ids as 64-bit numbers.
void join(const Ids& ids, std::size_t count, std::uint64_t* whole);

/// Ids in their own memory.
class IdList {
 public:
  IdList() = default;
  explicit IdList(std::span<const std::uint64_t> ids);

  operator Ids() const { return {lower_.data(), upper_.empty() ? nullptr : upper_.data()}; }

 private:
  std::vector<std::uint32_t> lower_, upper_;
};

}  // namespace motes::particles
