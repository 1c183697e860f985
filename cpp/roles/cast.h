// Which rank plays which role (paper 3.1.1): N ranks become a manager, an image generator and calculators.
#pragma once

#include <string>
#include <vector>

namespace motes::roles {

struct Cast {
  int manager = 0;
  int image_generator = 0;
  std::vector<int> calculators{0};  // rank of calculator 0, 1, ...: the order of the domains

  /// The number of the calculator that a rank plays, or -1.
  int calculator_of(int rank) const;

  /// Returns "calculator 0", "image generator, manager", or "spectator" for a rank without a role.
  std::string describe(int rank) const;

  bool operator==(const Cast&) const = default;
};

/// Returns the default cast. One rank plays all roles; of two, rank 0 is image generator and manager, rank 1
/// calculates; of three or more, rank 0 is the image generator, rank 1 the manager, and the rest calculate, as in the
/// paper.
Cast cast_auto(int size);

/// Returns cast_auto, but the manager also calculates unless it is the image generator.
Cast cast_managing(int size);

/// Returns a cast in which every rank calculates; rank 0 is also the manager and the image generator.
Cast cast_shared(int size);

/// Returns the cast of the survivors, which are renumbered; `survivors` has their old ranks, ascending. Each keeps its
/// roles. The role of a lost manager goes to the image generator, and vice versa; if both are lost, to the first
/// calculator. If no calculator is left, all ranks calculate.
Cast cast_left(const Cast& cast, const std::vector<int>& survivors);

/// Throws std::invalid_argument if a rank does not exist or calculates twice, or if no rank calculates.
void check(const Cast& cast, int size);

}  // namespace motes::roles
