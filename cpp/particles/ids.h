// Ids of particles, kept as halves. A system has to bear 2^32 particles before an upper half is not 0: until then it
// takes no memory, and no step reads it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace motes::particles {

constexpr std::uint32_t lower_half(std::uint64_t id) { return static_cast<std::uint32_t>(id); }
constexpr std::uint32_t upper_half(std::uint64_t id) { return static_cast<std::uint32_t>(id >> 32); }

/// Ids for reading: a plane of lower halves and, where one of them is not 0, a plane of upper ones.
struct Ids {
  const std::uint32_t* lower = nullptr;
  const std::uint32_t* upper = nullptr;  // null: all are 0

  Ids() = default;
  Ids(const std::uint32_t* lower_halves, const std::uint32_t* upper_halves)
      : lower(lower_halves), upper(upper_halves) {}

  std::uint64_t operator[](std::size_t i) const {
    return (upper == nullptr ? 0 : std::uint64_t{upper[i]} << 32) | lower[i];
  }

  /// From id number `first` on.
  Ids from(std::size_t first) const { return {lower + first, upper == nullptr ? nullptr : upper + first}; }
};

/// Writes `count` ids as whole numbers.
void join(const Ids& ids, std::size_t count, std::uint64_t* whole);

/// Ids with memory of their own.
class IdList {
 public:
  IdList() = default;
  explicit IdList(std::span<const std::uint64_t> ids);

  operator Ids() const { return {lower_.data(), upper_.empty() ? nullptr : upper_.data()}; }

 private:
  std::vector<std::uint32_t> lower_, upper_;
};

}  // namespace motes::particles
