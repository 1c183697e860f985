// sort: which particles are drawn first. An order is nothing that a kernel could give to one block of particles: the
// store is sorted when the list has run (recording/order.h), and the list goes past this action.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void sort(const actions::Parameters&, const actions::Block&, const actions::Step&) {}

}  // namespace motes::MOTES_ISA
