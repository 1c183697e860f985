// What must be known of an action between particles before it runs: the columns it reads of others, and its reach.
#pragma once

#include <cstddef>
#include <vector>

#include "actions/action.h"
#include "interactions/kernels.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::interactions {

/// A component of an attribute.
struct Component {
  int attribute = 0;
  int component = 0;

  bool operator==(const Component&) const = default;
};

/// Returns the law of an action between particles.
const Law& law_of(const actions::Action& action);

/// Lists the components of attributes, one bit each. Only the first component of size, a sphere's diameter, counts.
std::vector<Component> components_of(std::uint32_t attributes);
/// Returns the components of its sources that every action of this kind reads, position first.
std::vector<Component> read_by(const actions::Action& action);
/// Returns the components of its targets that an action changes, in the order of its results.
std::vector<Component> changed_by(const actions::Action& action);

/// Maxima over all ranks, agreed on before an interaction.
struct Extent {
  float radius = 0;        // largest radius, m
  float other_radius = 0;  // largest radius of the second system, m
  float displacement = 0;  // largest displacement along an axis in the step, m
  float masses = 0;        // largest 1 / mass, 1/kg; 0 if all masses are 1 kg
  float rounding = 0;  // rounding of positions at the cuts, m: see rounding_at; not measured, but known to all ranks

  /// Takes the larger of each measured number.
  void widen(const Extent& other);
  bool operator==(const Extent&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Extent& extent) {
  visit(extent.radius, extent.other_radius, extent.displacement, extent.masses);
}

/// Returns the rounding of predicted positions near a cut this far from the origin, m.
constexpr float rounding_at(float cut) { return cut * 0x1p-22f; }

/// Measures this rank's particles; leaves `rounding` 0. `second`: they belong to the action's second system.
Extent extent_of(const actions::Action& action, const particles::Store& store, float dt, bool second,
                 threads::Pool& pool);

/// Returns the largest distance, m, at which two particles interact by the action's law, at the (predicted) positions
/// that it uses.
float reach_of(const actions::Action& action, const Extent& extent);
/// Returns the largest current distance, m, at which two particles may interact by the action's law.
double range_of(const actions::Action& action, const Extent& extent);

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

/// Returns the radius, m, of a sphere of this size, m: 0 unless the size is positive.
inline float radius_of_size(float size) { return size > 0 ? 0.5f * size : 0.0f; }

/// Relative margin by which cells and halos exceed the reach.
inline constexpr double kMargin = 1e-6;

}  // namespace motes::interactions
