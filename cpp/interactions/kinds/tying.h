// tie: holds tied particles together, as in cloth and ropes (extended position-based dynamics: Macklin et al. 2016,
// "XPBD"), one iteration per step, as an action on velocities. In periodic space a tie leads to the partner's nearest
// image, so ghosts keep their particles' positions.
#pragma once

#include <cstddef>

#include "actions/action.h"

namespace motes::interactions {

/// Most bonds per particle that can tear: a float holds that many bits.
inline constexpr std::size_t kTearing = 24;

/// Throws std::invalid_argument if this process has no such ties, or they can tear and have too many bonds.
void check(const actions::Action& action);

/// Throws std::invalid_argument if two actions on one system tie the same particle by different ties and one can tear:
/// the bits of `torn` stand for the bonds of one of them only.
void check_together(const actions::Action& one, const actions::Action& other);

}  // namespace motes::interactions
