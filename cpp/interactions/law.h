// What a law between particles says of itself, in one struct beside its kernel (laws/law_*.h). What it reads and
// changes is said in actions/list.inc; all else follows: ghosts, columns, cells, where results go.
#pragma once

#include <cstdint>

namespace motes::interactions {

struct Task;

/// What a law says of each target: a plane per component of what it changes, in the order of the attributes.
inline constexpr std::size_t kMostResults = 7;

struct Law {
  /// Sums over the sources of each target. Null: the action does not act by summing over pairs.
  void (*act)(const Task&) = nullptr;
  /// Runs before `act`, over targets and the ghosts that they see: its result is the column `pressure`.
  void (*prepare)(const Task&) = nullptr;

  /// Returns how far apart two may be that see each other, in metres. Null: the sum of their radii.
  float (*reach)(const double* numbers) = nullptr;
  /// Returns the radius that the script gives to all spheres of the first or second system, in metres; 0: half of each
  /// one's size. Null: particles are points.
  float (*radius)(const double* numbers, bool second) = nullptr;
  /// Returns by which part of its radius a newborn sphere may overlap others: further in, it is removed; 0: it stays.
  float (*clear)(const double* numbers) = nullptr;

  bool looks_ahead = false;     // particles see each other where they will be at the end of the step
  bool inverse_masses = false;  // reads 1 / mass, in the column `inverse_mass`
  bool uniform = false;         // has a faster kernel for spheres of one radius, or particles of one mass
  bool skips_massless = false;  // spheres without a positive mass touch nobody
  bool remembers = false;       // keeps particles::Touches
  bool adds = false;            // results are added to the attribute; else they take its place
  bool between_systems = false;  // may act between the particles of two systems
};

}  // namespace motes::interactions
