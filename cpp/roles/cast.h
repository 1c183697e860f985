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

  /// "calculator 0", "image generator, manager", or "spectator" for a rank without a role.
  std::string describe(int rank) const;

  bool operator==(const Cast&) const = default;
};

/// One rank plays all roles; of two, rank 0 is image generator and manager, rank 1 calculates; of three or more, rank 0
/// is the image generator, rank 1 the manager, and the rest calculate, as in the paper.
Cast cast_auto(int size);

/// As cast_auto, but the manager calculates, too, where it is not the image generator.
Cast cast_managing(int size);

/// Every rank calculates; rank 0 is also the manager and the image generator.
Cast cast_shared(int size);

/// The cast of those that are left of it, who are renumbered: `survivors` has the old rank of each, ascending. Each
/// plays what it played. A lost manager's part goes to the image generator, and the other way round, or else to the
/// first calculator; where no calculator is left, all calculate.
Cast cast_left(const Cast& cast, const std::vector<int>& survivors);

/// Throws std::invalid_argument where a rank does not exist or calculates twice, or where no rank calculates.
void check(const Cast& cast, int size);

}  // namespace motes::roles
