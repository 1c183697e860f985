// tie: particles that are tied to each other, as in cloth and ropes (extended position-based dynamics: Macklin et al.
// 2016, "XPBD"), one iteration per step, as an action on velocities.
#pragma once

#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "interactions/act.h"
#include "interactions/ties.h"

namespace motes::interactions {

/// What a rank knows of tied particles in this step, by row of the bonds.
struct Knots {
  struct Knot {
    float place[3];     // m, in the interaction in which this was written down
    float at[3];        // at the end of the step, without ties
    float velocity[3];  // m/s
    float inverse;      // 1/mass; 0: pinned
    std::uint32_t torn;  // one bit for each of its bonds
    std::uint32_t seen = 0;  // in which interaction this was written down
  };
  std::vector<Knot> knots;
  std::uint32_t meeting = 0;
  float longest = 0;  // m: of the ties of this rank's particles, in the last interaction
};

/// What bounds how far apart tied particles are now.
struct Stretch {
  float longest = 0;  // m: at their last interaction
  float way = 0;      // m: the farthest that one has got since; infinite where that is not known
};
Stretch stretch_of(const Bonds& bonds, const Knots& knots, const particles::Store& store);

/// At most so many bonds of a particle can tear: a float holds that many bits.
inline constexpr std::size_t kTearing = 24;

/// Throws std::invalid_argument where this process keeps no such ties, or they have more bonds than can tear.
void check(const actions::Action& action);

/// Throws std::invalid_argument where two of one system's list tie the same particle by different ties, and one of them
/// can tear: the bits of `torn` stand for the bonds of one of them only.
void check_together(const actions::Action& one, const actions::Action& other);

/// Where the pinned particles of this rank are: x, y, z of each, -infinity for those that are elsewhere.
std::vector<float> pins_of(const Bonds& bonds, const particles::Store& store);

/// Acts on one rank's particles. `pins`: where all pinned ones are. Returns how many ties held, each from both of its
/// ends.
std::uint64_t tie(const actions::Action& action, const Bonds& bonds, float dt, const Side& side,
                  const std::vector<float>& pins, Knots& knots, threads::Pool& pool);

}  // namespace motes::interactions
