// Makes domains from scratch: equal parts of space, or of particles.
#pragma once

#include <memory>
#include <span>

#include "domains/domains.h"
#include "particles/periods.h"

namespace motes::domains {

/// Returns `count` equal slices of [low, high].
Domains equal_slices(double low, double high, int count, int axis = 0);

/// Returns the room that domains divide at the start: the period along periodic axes, the space's interval along
/// others.
Room room_of(const Space& space, const particles::Periods& periods);

/// Returns whether that room is bounded on all sides, as a curve needs it.
bool has_ends(const Space& space, const particles::Periods& periods);

/// Returns equal parts of a room: slices; bricks, each halved across its longest side in proportion to the domains on
/// both sides of the cut; stretches of a curve through the room; or parts of the ids, whatever the room.
Domains equal_parts(Axes axes, const Room& room, int count);
/// Returns equal parts of a room with the same interval along each axis.
Domains equal_parts(Axes axes, double low, double high, int count);

/// Returns `count` domains that each hold equally many of these coordinates (in any order).
Domains quantiles(std::span<const float> coordinates, int count, int axis = 0);

/// Returns stretches of a curve that each hold equally many of these particles.
Domains quantiles(std::shared_ptr<const Curve> curve, const Places& places, int count);

/// The axis across which a brick is halved: the one along which its particles extend farthest, for compact bricks; or
/// each axis in turn, to resolve all alike, however far they extend.
enum class Across : std::uint8_t { farthest, in_turn };

/// Returns domains along any axes that each hold equally many of these particles. Parts of the ids are equal.
Domains quantiles(Axes axes, const Places& places, int count, Across across = Across::farthest);

}  // namespace motes::domains
