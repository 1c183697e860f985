// The description of a law between particles: a struct beside its kernel (laws/law_*.h). The attributes it reads and
// changes are listed in actions/list.inc; ghosts, columns, cells and the use of results follow from these.
#pragma once

#include <cstdint>

namespace motes::interactions {

struct Task;

/// Most results of a law per target: one plane per component that it changes, in the order of the attributes.
inline constexpr std::size_t kMostResults = 7;

struct Law {
  /// Computes sums over each target's sources. Null: the family (kinds/) computes them.
  void (*act)(const Task&) = nullptr;
  /// Runs before `act`, for own particles and ghosts; its result becomes the column `pressure`.
  void (*prepare)(const Task&) = nullptr;

  /// Returns the largest distance, m, at which two particles interact. Null: the sum of their radii.
  float (*reach)(const double* numbers) = nullptr;
  /// Returns the radius, m, that the script gives to all spheres of the first or second system; 0: half of each one's
  /// size. Null: particles are points.
  float (*radius)(const double* numbers, bool second) = nullptr;
  /// Returns the part of its radius by which a newborn sphere may overlap others before it is removed; 0: none is
  /// removed.
  float (*clear)(const double* numbers) = nullptr;

  bool looks_ahead = false;     // acts on positions predicted for the end of the step
  bool inverse_masses = false;  // reads 1 / mass, in the column `inverse_mass`
  bool uniform = false;         // has a faster kernel for equal radii or equal masses
  bool skips_massless = false;  // spheres without a positive mass have no contacts
  bool remembers = false;       // keeps a neighbour list, whose pairs may have particles::Touches
  bool near = false;            // looks at near pairs of the list: see near_pairs.h
  bool adds = false;            // results are added to the attribute; else they replace it
  bool between_systems = false;  // may act between the particles of two systems
};

}  // namespace motes::interactions
