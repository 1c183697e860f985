// The kernels of meetings, in the build that suits this processor: each sums, for particles in lanes, over all that are
// within reach of them, in the order (cell, id).
#pragma once

#include <cstddef>
#include <cstdint>

#include "interactions/cell_list.h"

namespace motes::interactions {

/// What a kernel knows of the particles of one system: columns in the order of the cells, readable up to the next
/// multiple of particles::kPadding.
struct Party {
  CellsView cells;
  const float* const* column = nullptr;
  const Crowd* crowd = nullptr;  // for ids
};

/// Columns of a party: `at` first, then what the law reads.
enum At : int {
  at_x,
  at_y,
  at_z,
  value_x,
  value_y,
  value_z,
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
inline constexpr std::size_t party_results = 7;  // planes of what laws say, at most

/// What the laws are set to. Lengths in metres, times in seconds.
struct Terms {
  float reach = 0;  // who is farther away is not seen
  float strength = 0;  // gravitate, match: magnitude times the step
  float epsilon = 0;  // metres squared
  float step = 0;  // collide, contact, fluid
  float friction = 0;
  float restitution = 0;
  float stiffness = 0;  // contact: N/m
  float rolling_friction = 0;
  std::uint32_t now = 0;  // contact: the number of the sub-step, from 1 on
  float rest_density = 0;  // fluid: kg/m3
  float viscosity = 0;  // ten times that, m2/s
  float cohesion = 0;  // m/s2
  float slow = 0;  // m/s: those that approach each other more slowly do not rebound
  float sleep2 = 0;  // m2/s2
  int side = 0;  // 0: targets are among the sources; 1, 2: they are of the first or second of two systems
};

/// What was seen, for the log.
struct KernelStats {
  std::uint64_t pairs = 0;  // within reach; each counts for both of its particles
  bool softened = false;  // contact: springs were stiffer than the step allows
};

/// What two that touch remember, seen from one of them.
struct PairState {
  float slid[3], rolled[3];  // see particles::Touch
  std::uint32_t step;        // in which they last touched, from 1 on; 0: never
  std::uint32_t unused;
};

/// Pairs by their first particle's place in the order of the cells:
///
///     first   | 0 . . | 1 | 2 . . . | ...      place p has pairs begin[p] .. begin[p + 1] - 1
///     second  | 7 1 9 | 0 | 8 1 9 5 | ...      places, ascending by id
///     state   | one per pair                   kept as long as both stay listed
struct PairsView {
  const std::uint32_t* begin = nullptr;
  const std::uint32_t* second = nullptr;
  const std::uint64_t* ids = nullptr;  // of places
  PairState* state = nullptr;
};

struct Task {
  Party targets, sources;
  Terms terms;
  float* const* out = nullptr;  // planes by place: what the law says
  PairsView pairs;  // contact: who may touch whom
  const std::uint8_t* chosen = nullptr;  // contact: who is changed, by index; null: all
  std::size_t first_row = 0, last_row = 0;  // of the targets
  KernelStats* stats = nullptr;
};

/// Lists pairs whose surfaces are closer than the skin: without `second` how many there are of each place, and with it
/// which, from begin[place] on.
struct ListTask {
  Party spheres;  // both targets and sources: at, radius
  float skin = 0;
  std::uint32_t* count = nullptr;
  const std::uint32_t* begin = nullptr;
  std::uint32_t* second = nullptr;
  std::size_t first_row = 0, last_row = 0;
};

struct Kernels {
  /// v_i += sum of (x_j - x_i) strength / (r (r^2 + epsilon)): out is that sum.
  void (*gravitate)(const Task&);
  /// out: the value that its neighbours' values draw this particle's to.
  void (*match)(const Task&);
  /// out: velocity (3), contacts. With radii of their own, with masses.
  void (*collide[2][2])(const Task&);
  /// out: velocity (3), contacts, rotational velocity (3).
  void (*contact)(const Task&);
  void (*list_pairs)(const ListTask&);
  /// out: how hard each particle of a fluid pushes. The ghosts that targets see are targets too.
  void (*find_pressure)(const Task&);
  /// out: velocity (3). Reads the pressure of all.
  void (*fluid)(const Task&);
  /// See pull.h.
  void (*pull)(const float* const* sources, std::size_t count, float epsilon, const float* const* targets,
               std::size_t begin, std::size_t end, float* sums);
};

const Kernels& kernels();

}  // namespace motes::interactions
