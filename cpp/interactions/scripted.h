// Laws between particles that scripts write as expressions: `interact`.
#pragma once

#include "interactions/act.h"

namespace motes::interactions {

/// Acts on the particles of sides[0] by all that are within reach of them: of the same system, or of sides[1], whose
/// particles do not change. `time`: at the start of the sub-step, seconds. Does not communicate.
InteractionCounts act_by_script(const actions::Action& action, double time, float dt, const Side (&sides)[2],
                                Scratch& scratch, threads::Pool& pool);

}  // namespace motes::interactions
