// Compiled once for each instruction set: the laws between particles.
#include "interactions/clump_lanes.h"
#include "interactions/laws/all.h"  // includes all law_*.h of this folder; written by CMake
#include "interactions/laws/wall_lanes.h"
#include "interactions/list_pairs.h"
#include "interactions/pull.h"

namespace motes::MOTES_ISA {

namespace laws {
// Laws that do not sum over particles within reach: see engine/act/follow.h, interactions/pairs.h, interactions/tie.h.
inline constexpr interactions::Law follow = {};
inline constexpr interactions::Law pairs = {
    .reach = [](const double* recorded) { return actions::read_numbers<numbers::pairs>(recorded).radius; },
};
inline constexpr interactions::Law tie = {};
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
    find_walls,
    push_walls,
    place_spheres,
    turn_clumps,
};

}  // namespace motes::MOTES_ISA
