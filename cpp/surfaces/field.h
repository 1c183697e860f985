// The density around particles, on the nodes of a grid: exact sums, so they depend neither on the order of particles
// nor on who adds them.
//
// A particle's weight at distance d is (1 - (d / reach)^2)^3. With reach = kReach * radius and kWeight at its centre,
// both of these have a density of 1/2:
//
//   one particle alone, at `radius` from its centre
//   a block of particles 2 * radius apart, on a plane `radius` outside the outer centres
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "base/bytes.h"

namespace motes::surfaces {

/// How finely a surface is sampled, and how large its particles are; m.
struct Measure {
  double cell = 0;
  double radius = 0;

  bool operator==(const Measure&) const = default;
};

/// Throws std::invalid_argument unless the cell is kFinest .. kCoarsest times the radius.
inline constexpr double kFinest = 1.0 / 16, kCoarsest = 2;
void check(const Measure& measure);

/// Nodes along the side of a block.
inline constexpr int kBlock = 8;
inline constexpr std::size_t kNodes = std::size_t{kBlock} * kBlock * kBlock;

/// The density of a full block of particles. Greater sums stay at kMostSum.
inline constexpr std::uint32_t kFull = 1u << 20;
inline constexpr std::uint32_t kLevel = kFull / 2, kMostSum = 0xffffffffu;

/// Distance from a particle at which its weight becomes 0, in radii; its weight at its centre, in full densities.
inline constexpr double kReach = 2.4311, kWeight = 0.8724;

/// Most blocks of a field: 2 GB.
inline constexpr std::size_t kMostBlocks = std::size_t{1} << 20;

using NodeBlock = std::array<std::uint32_t, kNodes>;  // x fastest
using BlockKey = std::uint64_t;  // of a block's place

/// Places of blocks are within +-kFar in each direction.
inline constexpr std::int64_t kFar = 1 << 20;
constexpr BlockKey key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto part = [](std::int64_t place) { return static_cast<BlockKey>(place + kFar) & 0x1fffffu; };
  return part(z) << 42 | part(y) << 21 | part(x);
}
constexpr std::array<std::int64_t, 3> place_of(BlockKey key) {
  const auto part = [&](int shift) { return static_cast<std::int64_t>(key >> shift & 0x1fffffu) - kFar; };
  return {part(0), part(21), part(42)};
}

class Field {
 public:
  explicit Field(const Measure& measure) : measure_(measure) {}

  /// Adds particles first .. last - 1. Those whose position is not finite are left out. Stops without a result if the
  /// field becomes too large: see too_large().
  void add(const std::array<const float*, 3>& position, std::size_t first, std::size_t last);
  void add(const Field& other);
  void add(base::Reader& in);
  void write(base::Bytes& out) const;

  /// Returns whether the field has more than kMostBlocks blocks, or particles too far from the origin.
  bool too_large() const { return too_large_ || blocks_.size() > kMostBlocks; }

  const Measure& measure() const { return measure_; }
  std::size_t size() const { return blocks_.size(); }
  /// Returns the places of all blocks, ascending.
  std::vector<BlockKey> keys() const;
  /// Returns a block, or null if it is empty.
  const NodeBlock* find(BlockKey key) const;

 private:
  struct Reach;
  NodeBlock& at(BlockKey key);
  void add_one(const Reach& reach);

  Measure measure_;
  bool too_large_ = false;
  std::unordered_map<BlockKey, std::size_t> places_;
  std::vector<NodeBlock> blocks_;
  BlockKey last_key_ = ~BlockKey{0};
  std::size_t last_ = 0;
};

/// Throws std::invalid_argument: what a script asks for would need a field that is too large.
[[noreturn]] void refuse_size(const Measure& measure);

}  // namespace motes::surfaces
