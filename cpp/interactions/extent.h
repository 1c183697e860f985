// What must be known of an action between particles before it runs: the columns it reads of others, and its reach.
#pragma once

#include <cstddef>
#include <vector>

#include "actions/action.h"
#include "interactions/kernels.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::interactions {

/// Particles that a thread takes at once.
inline constexpr std::size_t kRange = std::size_t{1} << 15;

/// A component of an attribute.
struct Component {
  int attribute = 0;
  int component = 0;

  bool operator==(const Component&) const = default;
};

/// Returns the law of an action between particles.
const Law& law_of(const actions::Action& action);

/// Returns the components that an action reads of its sources, position first. `second`: of the second of two systems.
/// Empty for a system whose particles are not sources.
std::vector<Component> read_by(const actions::Action& action, bool second = false);
/// Returns the components of its targets that an action changes, in the order of its results.
std::vector<Component> changed_by(const actions::Action& action);

/// Maxima over all ranks, agreed on before an interaction.
struct Extent {
  float radius = 0;  // largest radius, m; of ties: longest tie at their last interaction
  float other_radius = 0;  // largest radius of the second system, m
  float displacement =
      0;  // largest displacement along an axis in the step, m; of tied particles: since their last interaction
  float rounding = 0;  // rounding of positions at the cuts, m: see rounding_at
  float masses = 0;  // largest 1 / mass, 1/kg; 0 if all masses are 1 kg

  bool operator==(const Extent&) const = default;
};

/// Returns the rounding of predicted positions near a cut this far from the origin, m.
constexpr float rounding_at(float cut) { return cut * 0x1p-22f; }

/// Measures this rank's particles; leaves `rounding` 0. `second`: they belong to the action's second system.
Extent extent_of(const actions::Action& action, const particles::Store& store, float dt, bool second,
                 threads::Pool& pool);

/// Returns the largest distance, m, at which two particles interact, at the (predicted) positions the action uses.
float reach_of(const actions::Action& action, const Extent& extent);
/// Returns the largest current distance, m, at which two particles may interact.
double range_of(const actions::Action& action, const Extent& extent);

/// Returns the fewest sub-steps per frame of `frame_s` seconds with which contact's springs are not softened, even
/// between the two lightest particles. 0 for other actions.
float substeps(const actions::Action& action, const Extent& extent, double frame_s);

/// Returns whether the action has a neighbour list, whose pairs may have states. The list and its ghosts are kept for
/// several sub-steps.
bool remembers(const actions::Action& action);
/// Returns whether the reach is the sum of two radii.
bool has_radius(const actions::Action& action);
/// Returns the radius, m, that the script gave for all particles of one side; 0: half of each one's size.
float given_radius(const actions::Action& action, bool second);

/// Returns the limit on predicted displacements, m. A faster particle passes through others anyway; without a limit,
/// one spark would make all ranks exchange everything.
constexpr float step_limit(float reach) { return reach; }

/// Mass, kg, below which a sphere counts as massless: it never pushes others, or has no contacts (Law::skips_massless).
/// The inverses of two larger masses have a sum in float32.
inline constexpr float kLeastMass = 0x1p-124f;

/// Returns the radius, m, of a sphere of this size, m: 0 unless the size is positive.
inline float radius_of_size(float size) { return size > 0 ? 0.5f * size : 0.0f; }

/// Relative margin by which cells and halos exceed the reach.
inline constexpr double kMargin = 1e-6;

}  // namespace motes::interactions
