// The kernels of meetings, in the build that suits this processor: each sums, for particles in lanes, over all that are
// within reach of them, in the order (cell, id).
#pragma once

#include <cstddef>
#include <cstdint>

#include "meetings/cells.h"

namespace motes::meetings {

/// What a kernel knows of the particles of one system: columns in the order of the cells, readable up to the next
/// multiple of particles::kPadding.
struct Party {
  CellsView cells;
  const float* const* column = nullptr;
  const Crowd* crowd = nullptr;  // for ids
};

/// Columns of a party: `at` first, then what the law reads.
enum At : int { at_x, at_y, at_z, value_x, value_y, value_z, contacts, radius, inverse_mass, party_columns };

/// What the laws are set to. Lengths in metres, times in seconds.
struct Terms {
  float reach = 0;  // who is farther away is not seen
  float strength = 0;  // gravitate, match: magnitude times the step
  float epsilon = 0;  // metres squared
  float step = 0;  // collide
  float friction = 0;
  float restitution = 0;
  float slow = 0;  // m/s: those that approach each other more slowly do not rebound
  float sleep2 = 0;  // m2/s2
  int side = 0;  // 0: targets are among the sources; 1, 2: they are of the first or second of two systems
};

/// What was seen, for the log.
struct Sight {
  std::uint64_t pairs = 0;  // within reach; each counts for both of its particles
};

struct Task {
  Party targets, sources;
  Terms terms;
  float* const* out = nullptr;  // planes by place: what the law says
  std::size_t first_row = 0, last_row = 0;  // of the targets
  Sight* sight = nullptr;
};

struct Kernels {
  /// v_i += sum of (x_j - x_i) strength / (r (r^2 + epsilon)): out is that sum.
  void (*gravitate)(const Task&);
  /// out: the value that its neighbours' values draw this particle's to.
  void (*match)(const Task&);
  /// out: velocity (3), contacts. With radii of their own, with masses.
  void (*collide[2][2])(const Task&);
  /// See pull.h.
  void (*pull)(const float* const* sources, std::size_t count, float epsilon, const float* const* targets,
               std::size_t begin, std::size_t end, float* sums);
};

const Kernels& kernels();

}  // namespace motes::meetings
