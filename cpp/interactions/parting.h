// Particles at the same place: what laws between particles take for the direction from one to the other.
#pragma once

#include "base/hash.h"
#include "interactions/kernels.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// What two particles at the same place have instead of a direction: a function of their ids, seen from the first one.
inline Float3 parting(std::uint64_t first, std::uint64_t second) {
  std::uint64_t bits = first * base::kGolden + second;
  const auto number = [&] {  // in [-1, 1)
    return static_cast<float>(static_cast<std::int32_t>(base::next_random(bits) >> 40) - (1 << 23)) * 0x1p-23f;
  };
  Float3 way = {number(), number(), number()};
  if (!(dot(way, way) > 1e-6f)) way = {1, 0, 0};
  return unit(way);
}

/// The same, seen from `target`: the first of two is that of the lower id, or of the first system.
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
