// What an action between particles needs to know before they meet: what it reads of others, and how far it sees.
#pragma once

#include <cstddef>
#include <vector>

#include "actions/action.h"
#include "interactions/kernels.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::interactions {

/// A thread takes so many particles at once.
inline constexpr std::size_t kRange = std::size_t{1} << 15;

/// A component of an attribute.
struct Component {
  int attribute = 0;
  int component = 0;
};

/// The law of an action between particles.
const Law& law_of(const actions::Action& action);

/// What an action reads of those that it sees: position first.
std::vector<Component> read_by(const actions::Action& action);
/// What it changes of its targets: its results, in this order.
std::vector<Component> changed_by(const actions::Action& action);

/// What all ranks agree on before particles meet: maxima over all of them.
struct Extent {
  float radius = 0;         // metres; of ties: the longest in their last interaction
  float other_radius = 0;   // of the second system
  float displacement = 0;   // metres along an axis, in the step; of tied ones: since their last interaction
  float rounding = 0;       // metres: of positions where ghosts are; see rounding_at
  float masses = 0;         // above 0: some particle has another mass than 1 kg

  bool operator==(const Extent&) const = default;
};

/// What looking ahead may round, for particles next to a cut this far from the origin of space.
constexpr float rounding_at(float cut) { return cut * 0x1p-22f; }

/// Of this rank's particles, but for rounding. `second`: they are of the action's second system.
Extent extent_of(const actions::Action& action, const particles::Store& store, float dt, bool second,
                 threads::Pool& pool);

/// How far apart two particles may be that see each other, at the places where the action looks for them.
float reach_of(const actions::Action& action, const Extent& extent);
/// How far apart they may be now.
double range_of(const actions::Action& action, const Extent& extent);

/// Whether its reach is that of two radii.
bool has_radius(const actions::Action& action);
/// The radius of the particles of one side that the script gave, in metres; 0: half of their size.
float given_radius(const actions::Action& action, bool second);

/// A particle that gets farther than this in a step, in metres, is looked for at most so far ahead: whom it would meet
/// beyond, it passes through in any case, and one spark does not make all ranks exchange what they have.
constexpr float step_limit(float reach) { return reach; }

/// Cells and halos are larger than the reach by this part of it.
inline constexpr double kMargin = 1e-6;

}  // namespace motes::interactions
