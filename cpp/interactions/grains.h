// Grains as the kernels of contact see them, in one record per place: a pair loads its two grains with a few wide loads
// instead of a gather per column.
//
//   places     | 0 | 1 | 2 | 3 | ...                grains[place], courses[place], out[place]
//   near pair  first second pair touched            push[2 n + 1]: on its first; push[2 n + 2]: on its second
//   pushes     | 3 8 | 1 | ...                      place p sums push[pushes[begin[p]]] ...: by the other's id
//   pushed     | 0 0 | 1 | ...                      the place of each
//
// Near pairs are those of the neighbour list that can touch within the next few sub-steps, on this rank.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "interactions/cell_list.h"
#include "particles/periods.h"

namespace motes::interactions {

struct KernelStats;
struct PairState;

/// Mass, kg, below which a sphere counts as massless: it never pushes others, or has no contacts (Law::skips_massless).
/// The inverses of two larger masses have a sum in float32.
inline constexpr float kLeastMass = 0x1p-124f;

struct alignas(16) Grain {
  float at[3], radius;  // m
  float velocity[3], inverse_mass;  // m/s, 1/kg
  float spin[3], unused;  // rad/s
};

/// Changes of a grain's velocity and spin, and the number of its touches.
struct alignas(16) GrainPush {
  float velocity[3], touches;
  float spin[3], unused;
};

/// Where a grain was when near pairs were found, and its motion per sub-step then. Near pairs hold while no grain is
/// far from its course.
struct alignas(16) Course {
  float at[3], radius;  // m
  float step[3], unused;  // m per sub-step
};

/// The periods of space, for displacements: one over half a period leads to the nearest image instead. The displacement
/// seen from the other end has the opposite bits.
struct Ends {
  bool any = false;
  float half[3], length[3], rest[3];  // a period is length + rest, m; half: infinite if there is none

  explicit Ends(const particles::Periods& periods);
};

/// Columns of grains by index: own ones, then ghosts.
struct GrainColumns {
  Column at[3], velocity[3], spin[3], size, mass;
  float given = 0;  // radius that the script gave, m; 0: half of each one's size
  bool given_own = false;  // that is the radius of own grains alone
};

/// Arranges grains by place, and tells which are far from their courses.
struct PlaceTask {
  const GrainColumns* columns = nullptr;
  const std::uint32_t* order = nullptr;  // index of each place
  std::uint32_t own = 0, count = 0;  // indices from `count` on are images, which are not placed
  Grain* grains = nullptr;
  const Course* courses = nullptr;  // null: there are none yet
  const Ends* ends = nullptr;
  float age = 0;  // of the courses, sub-steps
  float far = 0;  // m
  std::uint32_t from = 0, to = 0;  // places
};

/// Finds near pairs, pushes them apart, or sums pushes. All pairs are of one neighbour list.
struct TouchTask {
  const double* numbers = nullptr;  // the action's
  float dt = 0;  // s
  int side = 0;  // as in Task
  std::uint32_t now = 0;  // sub-step
  const Ends* ends = nullptr;
  bool apart = false;  // each end has its own state, 2 * pair + end, and is computed alone
  const std::uint8_t* chosen = nullptr;  // which particles may change, by index; null: all
  bool sums_alone = false;  // leave the grains' own velocity and spin out of the sums
  const std::uint32_t* order = nullptr;
  const std::uint64_t* ids = nullptr;  // by place
  std::uint32_t places = 0, own = 0;  // indices from `own` on are ghosts or images
  const std::uint32_t *listed_first = nullptr, *listed_second = nullptr;
  PairState* states = nullptr;  // by listed pair, as its first sees it
  const Grain* grains = nullptr;
  Course* courses = nullptr;
  float skin = 0, steps = 0;  // near pairs come closer than the skin, m, within this many sub-steps on their courses
  std::uint32_t *first = nullptr, *second = nullptr, *pair = nullptr;
  std::uint32_t* touched = nullptr;  // last sub-step in which a near pair touched
  GrainPush* push = nullptr;
  std::uint32_t *begin = nullptr, *pushes = nullptr, *pushed = nullptr;
  GrainPush* out = nullptr;
  std::uint32_t from = 0, to = 0;  // listed pairs, near pairs or places
  KernelStats* stats = nullptr;
};

/// Writes what act() computed to the columns of the store.
struct GiveTask {
  const GrainPush* out = nullptr;
  const std::uint32_t* order = nullptr;
  std::uint32_t own = 0;
  const std::uint8_t* chosen = nullptr;  // which particles may change, by index; null: all
  float* to[7] = {};  // velocity, spin, contacts
  const std::uint8_t* adds_to = nullptr;  // whose contacts are added to earlier ones, by index
  bool adds = false;  // all are, if adds_to is null
  std::uint32_t from = 0, last = 0;  // places
};

}  // namespace motes::interactions
