// Samples coordinates.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace motes::balance {

/// Returns at most `count` of the coordinates, one from each of `count` stretches of equal length. The position within
/// the stretch varies, so that no pattern in the order of the particles is missed. The same coordinates always give the
/// same sample.
std::vector<float> sampled(std::span<const float> coordinates, std::size_t count);

}  // namespace motes::balance
