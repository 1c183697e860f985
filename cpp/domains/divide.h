// Domains from scratch: equal parts of space, or of particles.
#pragma once

#include <span>

#include "domains/domains.h"

namespace motes::domains {

/// n equal slices of [low, high].
Domains equal_slices(double low, double high, int count, int axis = 0);

/// Equal parts of [low, high] along each of the axes: slices; bricks, each halved across its longest side, in
/// proportion to the domains on both sides of the cut; or parts of the ids, whatever the interval.
Domains equal_parts(Axes axes, double low, double high, int count);

/// The cuts that put equally many of these coordinates (in any order) into each of n domains.
Domains quantiles(std::span<const float> coordinates, int count, int axis = 0);

/// Across which axis a brick is halved: that along which its particles reach farthest, so that bricks are compact; or
/// each axis in turn, so that all are resolved alike, however far they reach.
enum class Across : std::uint8_t { farthest, in_turn };

/// The same along any axes. Parts of the ids are equal.
Domains quantiles(Axes axes, const Places& places, int count, Across across = Across::farthest);

}  // namespace motes::domains
