// How fast messages travel, measured once at the start of a run for its log.
#pragma once

#include <vector>

#include "engine/session/rank.h"

namespace motes::engine {

/// Messages between two ranks.
struct Link {
  int rank = 0, other = 0;
  double message_s = 0;  // from sending a short message to having received it
  double byte_s = 0;     // in addition, per byte of a longer one
};

/// Returns, on the manager, its links to at most eight ranks and those of at most eight pairs of calculators with
/// neighbouring domains; on other ranks nothing. They are measured one after another. Collective.
std::vector<Link> measure_links(Rank& rank);

}  // namespace motes::engine
