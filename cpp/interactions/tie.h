// tie: holds tied particles together, as in cloth and ropes (extended position-based dynamics: Macklin et al. 2016,
// "XPBD"), one iteration per step, as an action on velocities.
#pragma once

#include <cstdint>
#include <vector>

#include "actions/action.h"
#include "interactions/act.h"
#include "interactions/ties.h"
#include "particles/periods.h"

namespace motes::interactions {

/// A rank's record of tied particles in this step, by row of Bonds.
struct Knots {
  struct Knot {
    float place[3];     // position at interaction `seen`, m
    float at[3];        // position predicted for the end of the step, without ties, m
    float velocity[3];  // m/s
    float inverse;      // 1/mass; 0: pinned
    std::uint32_t torn;  // one bit per bond
    std::uint32_t seen = 0;  // number of the interaction in which this was noted
  };
  std::vector<Knot> knots;
  std::uint32_t meeting = 0;
  float longest = 0;  // longest tie of this rank's particles at the last interaction, m
};

/// Bounds on the present distance of tied particles, or of their nearest images.
struct TieBounds {
  float longest = 0;  // longest tie at the last interaction, m
  float way = 0;      // largest distance travelled since, m; infinite if unknown
};
TieBounds stretch_of(const Bonds& bonds, const Knots& knots, const particles::Store& store,
                     const particles::Periods& periods);

/// Most bonds per particle that can tear: a float holds that many bits.
inline constexpr std::size_t kTearing = 24;

/// Throws std::invalid_argument if this process has no such ties, or they can tear and have too many bonds.
void check(const actions::Action& action);

/// Throws std::invalid_argument if two actions on one system tie the same particle by different ties and one can tear:
/// the bits of `torn` stand for the bonds of one of them only.
void check_together(const actions::Action& one, const actions::Action& other);

/// Returns positions (x, y, z) of all pinned particles; -infinity for those of other ranks.
std::vector<float> pins_of(const Bonds& bonds, const particles::Store& store);

/// Acts on this rank's particles. `pins`: positions of all pinned particles. In periodic space a tie leads to the
/// partner's nearest image, so ghosts keep their particles' positions. Returns the number of ties that held, counted at
/// both ends.
std::uint64_t tie(const actions::Action& action, const Bonds& bonds, float dt, const particles::Periods& periods,
                  const Side& side, const std::vector<float>& pins, Knots& knots, threads::Pool& pool);

}  // namespace motes::interactions
