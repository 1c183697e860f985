// The kernels of pair interactions, in the build for this processor. Each sums, for targets in lanes, over all sources
// within reach, in the order (cell, id).
#pragma once

#include <cstddef>
#include <cstdint>

#include "interactions/cell_list.h"
#include "particles/touches.h"

namespace motes::interactions {

/// The particles of one system as a kernel sees them: columns in the order of the cells, readable up to the next
/// multiple of particles::kPadding.
struct Party {
  CellsView cells;
  const float* const* column = nullptr;
  const Crowd* crowd = nullptr;  // for ids
};

/// Columns of a party: positions first, then what the law reads.
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
inline constexpr std::size_t party_results = 7;  // most planes of results of any law

/// Parameters of the laws. Lengths in metres, times in seconds.
struct Terms {
  float reach = 0;  // particles farther away have no effect
  float strength = 0;  // gravitate, match: magnitude * step
  float epsilon = 0;  // metres squared
  float step = 0;  // length of the sub-step: collide, contact, fluid
  float friction = 0;
  float restitution = 0;
  float stiffness = 0;  // contact: N/m
  float rolling_friction = 0;
  std::uint32_t now = 0;  // contact: number of the sub-step, from 1 on
  float rest_density = 0;  // fluid: kg/m3
  float viscosity = 0;  // fluid: ten times the viscosity, m2/s
  float cohesion = 0;  // m/s2
  float slow = 0;  // collide: slower approaches do not rebound, m/s
  float sleep2 = 0;  // m2/s2
  int side = 0;  // 0: one system; 1, 2: targets are of the first or second of two systems
};

/// Counts for the log.
struct KernelStats {
  std::uint64_t pairs = 0;  // pairs within reach, counted once per end
  bool softened = false;  // contact: springs were softened because the step is too long
};

struct Task {
  Party targets, sources;
  Terms terms;
  float* const* out = nullptr;  // planes of results, in the order of the cells
  particles::Touches* touches = nullptr;  // contact: memory of this rank's particles, by index
  const std::uint8_t* chosen = nullptr;  // contact: which particles are changed, by index; null: all
  std::size_t first_row = 0, last_row = 0;  // rows of targets to work on
  KernelStats* stats = nullptr;
};

struct Kernels {
  /// Writes the change of velocity: sum of (x_j - x_i) strength / (r (r^2 + epsilon)).
  void (*gravitate)(const Task&);
  /// Writes the new value: the particle's own, drawn to those of its neighbours.
  void (*match)(const Task&);
  /// Writes velocity (3) and contacts. Indexed by [particles have radii][particles have masses].
  void (*collide[2][2])(const Task&);
  /// Writes velocity (3), contacts, rotational velocity (3).
  void (*contact)(const Task&);
  /// Writes the pressure of each particle of a fluid. Ghosts within reach of own particles must be targets too.
  void (*find_pressure)(const Task&);
  /// Writes velocity (3). Reads the pressure of all particles.
  void (*fluid)(const Task&);
  /// Sums gravitation over a list of sources: see pull.h.
  void (*pull)(const float* const* sources, std::size_t count, float epsilon, const float* const* targets,
               std::size_t begin, std::size_t end, float* sums);
};

const Kernels& kernels();

}  // namespace motes::interactions
