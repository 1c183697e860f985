// The moments of far cells, summed over all calculators.
#pragma once

#include <cstdint>

#include "frame/rank.h"
#include "frame/round.h"
#include "meetings/pyramid.h"

namespace motes::frame {

/// Calculators, collective: adds up what each has, which must be as long everywhere. Each sums its part of the leaves,
/// and tells it to the others: 2 (n - 1) messages, which together carry twice the moments. Returns the bytes sent.
std::uint64_t add_moments(Rank& rank, const Round& round, meetings::Moments& moments);

}  // namespace motes::frame
