// Laws that scripts write as expressions: `interact`.
#pragma once

#include "interactions/act.h"

namespace motes::interactions {

/// Acts on the particles of sides[0]. Their sources are within reach of them, in the same system or in sides[1], whose
/// particles do not change. `time`: start of the sub-step, s. Does not communicate.
InteractionCounts act_by_script(const actions::Action& action, double time, float dt, const Side (&sides)[2],
                                Scratch& scratch, threads::Pool& pool);

}  // namespace motes::interactions
