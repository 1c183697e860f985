// The kernels of pair interactions, compiled once for each instruction set.
#include "interactions/collide.h"
#include "interactions/contact.h"
#include "interactions/fluid.h"
#include "interactions/gravitate.h"
#include "interactions/match.h"
#include "interactions/pull.h"

namespace motes::MOTES_ISA {

extern const interactions::Kernels meeting_kernels;
const interactions::Kernels meeting_kernels = {
    gravitate,
    match,
    {{collide<false, false>, collide<false, true>}, {collide<true, false>, collide<true, true>}},
    contact,
    find_pressure,
    fluid,
    pull,
};

}  // namespace motes::MOTES_ISA
