// Directions for pairs of particles at the same position.
#pragma once

#include "base/hash.h"
#include "interactions/kernels.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// Returns a unit vector from the first particle to the second, derived from their ids.
inline Float3 parting(std::uint64_t first, std::uint64_t second) {
  std::uint64_t bits = first * base::kGolden + second;
  const auto number = [&] {  // in [-1, 1)
    return static_cast<float>(static_cast<std::int32_t>(base::next_random(bits) >> 40) - (1 << 23)) * 0x1p-23f;
  };
  Float3 way = {number(), number(), number()};
  if (!(dot(way, way) > 1e-6f)) way = {1, 0, 0};
  return unit(way);
}

/// Returns the unit vector from target to source; both ends of a pair get opposite vectors. The first particle of a
/// pair has the lower id, or belongs to the first system.
inline Float3 parting(std::uint64_t target, std::uint64_t source, int side) {
  const bool first = side == 0 ? target < source : side == 1;
  return first ? parting(target, source) : times(parting(source, target), -1);
}

inline std::uint64_t id_of(const interactions::Party& party, std::uint32_t place) {
  const std::uint32_t i = party.cells.order[place];
  const interactions::Crowd& crowd = *party.crowd;
  return i < crowd.own ? crowd.own_ids[i] : crowd.copied_ids[i - crowd.own];
}

}  // namespace motes::MOTES_ISA
