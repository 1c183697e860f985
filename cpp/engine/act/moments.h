// The moments of far cells, summed over all calculators.
#pragma once

#include <cstdint>

#include "engine/session/rank.h"
#include "engine/session/round.h"
#include "interactions/pyramid.h"

namespace motes::engine {

/// Calculators, collective: adds up what each has, which must be as long everywhere. Each sums its part of the leaves,
/// and tells it to the others: 2 (n - 1) messages, which together carry twice the moments. Returns the bytes sent.
std::uint64_t add_moments(Rank& rank, const Round& round, interactions::Moments& moments);

}  // namespace motes::engine
