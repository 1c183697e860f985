// Compiled once for each instruction set: the kernels of meetings.
#include "interactions/collide.h"
#include "interactions/contact.h"
#include "interactions/fluid.h"
#include "interactions/gravitate.h"
#include "interactions/list_pairs.h"
#include "interactions/match.h"
#include "interactions/pull.h"

namespace motes::MOTES_ISA {

extern const interactions::Kernels meeting_kernels;
const interactions::Kernels meeting_kernels = {
    gravitate,
    match,
    {{collide<false, false>, collide<false, true>}, {collide<true, false>, collide<true, true>}},
    contact,
    list_pairs,
    find_pressure,
    fluid,
    pull,
};

}  // namespace motes::MOTES_ISA
