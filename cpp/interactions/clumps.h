// Clumps: particles that are rigid groups of spheres. For each sub-step a clump's spheres become particles of their
// own, which meet others and walls by the law of contact; what pushes them is summed onto the clump. What its spheres
// remember travels with the clump: a Touch's part says which of them has it.
#pragma once

#include "interactions/act.h"

namespace motes::interactions {

/// The spheres of a template, which is a table.
std::vector<ClumpSphere> spheres_of(actions::TableKey key);
/// Writes where the spheres of a store's clumps are, in planes of SphereAt: sphere k of clump i at k * size + i.
void place_spheres(const particles::Store& store, const std::vector<ClumpSphere>& spheres, float* const* placed,
                   threads::Pool& pool);
/// Returns the radius of a ball about the centre that holds a clump of size 1, metres.
float bounding_radius(const std::vector<ClumpSphere>& spheres);

/// Acts on the clumps of one system. Does not communicate.
InteractionCounts act_on_clumps(const actions::Action& action, const Extent& extent, float dt, const Side& side,
                                Scratch& scratch, threads::Pool& pool);
/// See list_holds(). Leaves the spheres in the scratch: as long as their lists hold, act_on_clumps() takes them.
bool clumps_hold(const actions::Action& action, const Side& side, Scratch& scratch, threads::Pool& pool);

}  // namespace motes::interactions
