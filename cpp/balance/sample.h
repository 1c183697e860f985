// A few of many coordinates.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace motes::balance {

/// At most `count` of the coordinates, spread over all of them, one from each of `count` stretches of equal length;
/// where in its stretch changes from one to the next, so that no pattern of the particles' order hides. The same for
/// the same coordinates.
std::vector<float> sampled(std::span<const float> coordinates, std::size_t count);

}  // namespace motes::balance
