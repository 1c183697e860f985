// Kernels of the laws between particles, in the build that suits this processor. Each sums over the sources within
// reach of a target, in a fixed order.
#pragma once

#include <cstddef>
#include <cstdint>

#include "actions/numbers.h"
#include "expressions/formula.h"
#include "interactions/cell_list.h"
#include "interactions/grains.h"
#include "interactions/law.h"
#include "particles/blocks.h"
#include "shapes/shape.h"

namespace motes::interactions {

/// Returns the length of a kernel's column of `count` values: a vector may begin at any place and read beyond the last
/// one.
constexpr std::size_t padded(std::size_t count) { return count + 2 * particles::kPadding; }

/// The particles of one system as a kernel sees them: padded columns in the order of the cells.
struct Party {
  CellsView cells;
  const float* const* column = nullptr;
  const Crowd* crowd = nullptr;  // for ids
};

/// Columns of a party: positions, what the law reads, and values derived from these.
enum At : int {
  at_x,
  at_y,
  at_z,
  velocity_x,
  velocity_y,
  velocity_z,
  contacts,
  radius,
  inverse_mass,
  spin_x,
  spin_y,
  spin_z,
  mass,
  pressure,
  party_columns
};

/// Counts for the log.
struct KernelStats {
  std::uint64_t pairs = 0;  // pairs within reach, counted once per end
};

/// Largest stiffness of a spring between grains, in units of m / step^2, where m is the reduced mass of two spheres. A
/// touch lasts pi sqrt(m / stiffness), at least five steps, so even a particle with twelve touches is stable. Stiffer
/// springs would throw particles apart and are softened.
inline constexpr float kMostStiff = 0.39f;

/// The state of a touching pair, as its first particle remembers it.
struct PairState {
  float slid[3], rolled[3];  // see particles::Touch
  std::uint32_t step;        // sub-step of the last touch, from 1; 0: never
  std::uint32_t unused;
};

/// Numbers of a pair's state in one PairState; a law with more uses several consecutive PairStates per pair.
inline constexpr int kStateNumbers = 6;

/// Pairs, by the place of their first particle in the order of the cells:
///
///     first   | 0 . . | 1 | 2 . . . | ...      place p has pairs begin[p] .. begin[p + 1] - 1
///     second  | 7 1 9 | 0 | 8 1 9 5 | ...      places, ascending by id
///     state   | `parts` per pair               kept as long as both stay listed
struct PairsView {
  const std::uint32_t* begin = nullptr;
  const std::uint32_t* second = nullptr;
  const std::uint64_t* ids = nullptr;  // by place
  PairState* state = nullptr;
  std::uint32_t parts = 1;
};

/// One law over some rows of targets. Lengths in metres, times in seconds.
struct Task {
  Party targets, sources;
  const double* numbers = nullptr;  // the action's numbers: see numbers_of
  float reach = 0;  // sources farther away are ignored
  float dt = 0;
  int side = 0;  // 0: targets are among the sources; 1, 2: targets are of the first or second of two systems
  bool radii = false, masses = false;  // whether particles have individual radii and masses: Law::uniform
  bool fast = false;  // whether predicted displacements may have been cut off: see step_limit
  double gravity = 0;  // see Collisions
  float* const* out = nullptr;  // the law's results, planes by place
  std::size_t first_row = 0, last_row = 0;  // rows of targets
  KernelStats* stats = nullptr;
};

/// Lists pairs whose surfaces are closer than the skin. Without `second` it counts the pairs of each place; with it, it
/// writes them from begin[place] on.
struct ListTask {
  Party spheres;  // targets and sources; columns: at, radius
  float skin = 0;
  bool ghosts_alone = false;  // all second particles are ghosts
  bool once = false;  // a pair of own particles is listed once, at its first place
  std::uint32_t* count = nullptr;
  const std::uint32_t* begin = nullptr;
  std::uint32_t* second = nullptr;
  std::size_t first_row = 0, last_row = 0;
};

/// How far own particles have moved, by index, since a list was made.
struct WearTask {
  Column at[3], size, mass;
  float given = 0;              // radius, m; 0: half of each one's size
  bool skips_massless = false;  // see Law
  const float* listed[3] = {};  // where they were, m, and their radii then; a vector may read beyond the last one
  const float* listed_radius = nullptr;
  const Ends* ends = nullptr;
  float skin = 0;               // m
  std::size_t from = 0, to = 0;
};
struct Worn {
  float way2 = 0;  // square of the largest displacement, m2
  bool out = false;  // a particle has moved or grown by half of the skin
};

/// Spheres and one wall, in a sub-step.
struct WallTask {
  const shapes::Shape* wall = nullptr;  // not a union
  const shapes::Shape* origin = nullptr;  // whose first point torques are about: the wall, or the union's first part
  std::uint32_t number = 0;             // number of the wall
  float start = 0, end = 1;             // part of the frame that the sub-step covers
  const Grain* grains = nullptr;         // by place; as many as a vector has may follow the last one
  const std::uint32_t* order = nullptr;  // index of each place's particle
  std::uint32_t own = 0;                 // indices below are this rank's own
  const std::uint8_t* chosen = nullptr;  // which particles may change, by index; null: all
  const double* numbers = nullptr;       // contact's numbers, for this wall
  float dt = 0;                          // seconds
  std::uint32_t first = 0, last = 0;     // places
};

/// Touches of spheres with one wall. Those of one place are sorted by number.
struct WallTouches {
  static constexpr std::uint32_t kMost = 1024, kRoom = kMost + particles::kPadding;

  std::uint32_t count = 0;
  std::uint32_t place[kRoom], number[kRoom];  // which face of which wall: see shapes/nearest.h
  float distance[kRoom], towards[3][kRoom];   // metres, and a unit vector from the centre to the wall
  float slid[3][kRoom], rolled[3][kRoom];     // see particles::Touch
  float change[6][kRoom];                     // of velocity and rotational velocity
  float force[3][kRoom], torque[3][kRoom];    // on the wall, N, and about its origin, N m
};

/// Columns of clumps, in the order in which contact_clumps reads them.
enum ClumpAt : int {
  clump_x,
  clump_velocity = clump_x + 3,
  clump_size = clump_velocity + 3,
  clump_mass,
  clump_orientation,
  clump_spin = clump_orientation + 4,
  clump_columns = clump_spin + 3
};
/// Columns of the spheres of clumps, in the order in which contact reads them.
enum SphereAt : int {
  sphere_x,
  sphere_velocity = sphere_x + 3,
  sphere_spin = sphere_velocity + 3,
  sphere_size = sphere_spin + 3,
  sphere_mass,
  sphere_columns
};

/// A sphere of a clump of size 1: its centre in the clump's axes, and its radius, m.
struct ClumpSphere {
  float at[3], radius;
};

/// Some clumps of one template. Sphere k of clump i is at k * stride + i in the columns of spheres.
struct ClumpTask {
  const float* const* column = nullptr;  // ClumpAt, by clump
  const ClumpSphere* spheres = nullptr;
  std::size_t count = 0;  // spheres of a clump
  std::size_t stride = 0;
  float* const* placed = nullptr;      // SphereAt: place_spheres() writes it
  const float* const* sums = nullptr;  // by sphere: changes of velocity and spin, and number of other spheres touched
  float inertia[6] = {}, inverse[6] = {};  // tensor of inertia and its inverse (xx, yy, zz, xy, xz, yz) of a clump of 1
                                           // kg and size 1, m^2 and 1/m^2
  const float* turned = nullptr;  // by clump: 1 if an earlier contact has acted in this sub-step
  float dt = 0;  // seconds
  float* const* out = nullptr;  // by clump: velocity, spin and number of touches: turn_clumps() writes it
  std::size_t first = 0, last = 0;  // clumps
};

/// Where a column of a scripted law's formula comes from.
struct LeafSource {
  enum class How : std::uint8_t {
    own_by_place,  // of the target
    own_by_index,  // of the target, by index in the store
    other,  // of the source, by place
    same,  // one value for all
    shared,  // the distance, or a component of the normal: plane `number` of kShared
    state,  // `number` of the pair's state
  };
  How how = How::same;
  int number = 0;
  const float* column = nullptr;
  float value = 0;
};

/// Planes that the kernel computes itself: the distance, and the normal's components.
inline constexpr int kShared = 4;

/// Pairs that a formula computes at once, and the length of a plane for them.
inline constexpr std::uint32_t kFormulaPairs = 256, kFormulaPlane = kFormulaPairs + 2 * particles::kPadding;

/// A scripted law over some rows of targets: its formula's values for each pair within reach are summed, or kept as the
/// pair's state.
struct ScriptedTask {
  CellsView targets;
  PairsView pairs;
  const float* at[3] = {};  // by place
  float reach2 = 0;
  float time = 0;
  std::uint32_t now = 0;  // as in Task
  const std::uint8_t* chosen = nullptr;  // as in Task
  bool shares = false;  // whether the formula reads the distance or the normal
  const LeafSource* leaves = nullptr;
  std::size_t leaf_count = 0;
  const expressions::FormulaStep* constants = nullptr;
  std::size_t constant_count = 0;
  const expressions::FormulaStep* steps = nullptr;
  std::size_t step_count = 0;
  const std::uint16_t* sums = nullptr;  // planes of the values to sum
  std::size_t sum_count = 0;
  const std::int32_t* states = nullptr;  // plane of the next value of each number of the state; -1: unchanged
  int state_count = 0;
  float* shared = nullptr;  // kShared planes of kFormulaPlane
  float* const* plane = nullptr;  // the formula's planes; the kernel fills those of columns
  float* const* out = nullptr;  // one plane per sum, by place
  std::size_t first_row = 0, last_row = 0;
  KernelStats* stats = nullptr;
};

struct Kernels {
  Law law[actions::kKinds];
  void (*scripted)(const ScriptedTask&);
  void (*list_pairs)(const ListTask&);
  /// See pull.h.
  void (*pull)(const float* const* sources, std::size_t count, float epsilon, const float* const* targets,
               std::size_t begin, std::size_t end, float* sums);
  Worn (*measure_wear)(const WearTask&);
  /// See laws/touch_lanes.h.
  bool (*place_grains)(const PlaceTask&);
  void (*set_courses)(const TouchTask&);
  std::uint32_t (*find_near)(const TouchTask&);
  void (*order_pushes)(const TouchTask&);
  void (*touch)(const TouchTask&);
  void (*sum_pushes)(const TouchTask&);
  void (*give_pushes)(const GiveTask&);
  /// See laws/wall_lanes.h.
  std::uint32_t (*find_walls)(const WallTask&, WallTouches&);
  void (*push_walls)(const WallTask&, WallTouches&);
  /// See clump_lanes.h.
  void (*place_spheres)(const ClumpTask&);
  void (*turn_clumps)(const ClumpTask&);
};

const Kernels& kernels();

}  // namespace motes::interactions
