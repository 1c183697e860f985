// Domains from scratch: equal parts of space, or of particles.
#pragma once

#include <memory>
#include <span>

#include "domains/domains.h"
#include "particles/periods.h"

namespace motes::domains {

/// n equal slices of [low, high].
Domains equal_slices(double low, double high, int count, int axis = 0);

/// Returns what domains divide at the start: a period along each periodic axis, along others the space's interval.
Room room_of(const Space& space, const particles::Periods& periods);

/// Tells whether that room has ends of its own on all sides, as a curve needs them.
bool has_ends(const Space& space, const particles::Periods& periods);

/// Equal parts of a room along each of the axes: slices; bricks, each halved across its longest side, in proportion to
/// the domains on both sides of the cut; stretches of a curve through the room; or parts of the ids, whatever the room.
Domains equal_parts(Axes axes, const Room& room, int count);
/// Equal parts of the same interval along each of the axes.
Domains equal_parts(Axes axes, double low, double high, int count);

/// The cuts that put equally many of these coordinates (in any order) into each of n domains.
Domains quantiles(std::span<const float> coordinates, int count, int axis = 0);

/// The same along a curve.
Domains quantiles(std::shared_ptr<const Curve> curve, const Places& places, int count);

/// Across which axis a brick is halved: that along which its particles reach farthest, so that bricks are compact; or
/// each axis in turn, so that all are resolved alike, however far they reach.
enum class Across : std::uint8_t { farthest, in_turn };

/// The same along any axes. Parts of the ids are equal.
Domains quantiles(Axes axes, const Places& places, int count, Across across = Across::farthest);

}  // namespace motes::domains
