// The families of actions between particles: a function per family of list.inc, which returns its class for a meeting.
#pragma once

#include <memory>

#include "interactions/pair_action.h"

namespace motes::interactions {

namespace families {
#define MOTES_ACTION(...)
#define MOTES_INTERACTION(name, family, ...) std::unique_ptr<PairAction> family(const Meeting& meeting);
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
}  // namespace families

/// Returns the action of a meeting's first side, between this rank's particles. The meeting must outlive it.
std::unique_ptr<PairAction> begin(const Meeting& meeting);

}  // namespace motes::interactions
