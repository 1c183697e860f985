// Compiled once for each instruction set: the laws between particles.
#include "interactions/clump_lanes.h"
#include "interactions/laws/all.h"  // includes all law_*.h of this folder; written by CMake
#include "interactions/laws/wall_lanes.h"
#include "interactions/list_pairs.h"
#include "interactions/pull.h"

namespace motes::MOTES_ISA {

// A law of laws/ hides the empty one of the same name, which is for families that need none.
namespace no_laws {
#define MOTES_ACTION(...)
#define MOTES_INTERACTION(name, ...) inline constexpr interactions::Law name = {};
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
}  // namespace no_laws
namespace laws {
using namespace no_laws;
}  // namespace laws

extern const interactions::Kernels interaction_kernels;
const interactions::Kernels interaction_kernels = {
    {
#define MOTES_ACTION(name, ...) {},
#define MOTES_INTERACTION(name, ...) laws::name,
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
    },
    scripted,
    list_pairs,
    pull,
    measure_wear,
    place_grains,
    set_courses,
    find_near,
    order_pushes,
    touch,
    sum_pushes,
    give_pushes,
    find_walls,
    push_walls,
    place_spheres,
    turn_clumps,
};

}  // namespace motes::MOTES_ISA
