// Lists pairs of particles within reach of each other, for a script's own function (paper 3.1.5: users add collision
// procedures).
#pragma once

#include <cstdint>
#include <vector>

#include "interactions/cell_list.h"

namespace motes::interactions {

/// Pairs, each seen from one of this rank's particles, in the order (cell, id) of that particle, then of the other.
struct PairList {
  std::vector<std::uint32_t> own;       // index in the store
  std::vector<std::uint64_t> id, other_id;
  std::vector<float> position, other_position;  // m: x, y, z of each
  std::vector<float> velocity, other_velocity;  // m/s

  std::size_t size() const { return own.size(); }
};

/// Lists the pairs within `reach` m. `column`: positions and velocities in the order of the cells, six planes.
/// `chosen`: which of this rank's particles; null: all.
PairList pairs_within(float reach, const Cells& cells, const Crowd& crowd, const float* const (&column)[6],
                      const std::vector<std::uint8_t>* chosen);

}  // namespace motes::interactions
