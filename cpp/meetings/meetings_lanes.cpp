// Compiled once for each instruction set: the kernels of meetings.
#include "meetings/collide.h"
#include "meetings/contact.h"
#include "meetings/fluid.h"
#include "meetings/gravitate.h"
#include "meetings/match.h"
#include "meetings/pull.h"

namespace motes::MOTES_ISA {

extern const meetings::Kernels meeting_kernels;
const meetings::Kernels meeting_kernels = {
    gravitate,
    match,
    {{collide<false, false>, collide<false, true>}, {collide<true, false>, collide<true, true>}},
    contact,
    find_pressure,
    fluid,
    pull,
};

}  // namespace motes::MOTES_ISA
