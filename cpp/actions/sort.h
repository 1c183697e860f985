// sort: sets the drawing order. A kernel sees only one block of particles and cannot sort them all, so the store is
// sorted after the list has run (program/order.h), and the list skips this action.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void sort(const actions::Parameters&, const actions::Block&, const actions::Step&) {}

}  // namespace motes::MOTES_ISA
