// Clumps: particles that are rigid groups of spheres. In each sub-step a clump's spheres are expanded into particles
// that touch others and walls by the law of contact; the pushes on them are summed onto the clump. The touches of the
// spheres travel with the clump: a Touch's part is the number of its sphere.
#pragma once

#include "interactions/act.h"

namespace motes::interactions {

/// Returns the spheres of a clump template, which is stored as a table.
std::vector<ClumpSphere> spheres_of(actions::TableKey key);
/// Writes the SphereAt columns of all spheres of a store's clumps: sphere k of clump i is at k * size + i.
void place_spheres(const particles::Store& store, const std::vector<ClumpSphere>& spheres, float* const* placed,
                   threads::Pool& pool);
/// Returns the radius, m, of the ball around its centre that encloses a clump of size 1.
float bounding_radius(const std::vector<ClumpSphere>& spheres);

/// Acts on the clumps of one system. Does not communicate.
InteractionCounts act_on_clumps(const actions::Action& action, const Extent& extent, float dt, const Side& side,
                                Scratch& scratch, threads::Pool& pool);
/// Lets the particles of two systems touch each other, spheres or clumps; the walls are those of each action. Does not
/// communicate.
InteractionCounts contact_between(const actions::Action* const (&actions)[2], const Extent& extent, float dt,
                                  const Side (&sides)[2], Scratch& scratch, threads::Pool& pool);

/// Like list_holds(), for clumps. Leaves the expanded spheres in the scratch; act_on_clumps() reuses them if all lists
/// hold.
bool clumps_hold(const actions::Action& action, const Side& side, Scratch& scratch, threads::Pool& pool);

}  // namespace motes::interactions
