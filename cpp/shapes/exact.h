// On which side of a surface places are, and where paths meet it, so that rounding cannot move a particle to the other
// side.
//
// Places and numbers of shapes are of single precision. In double precision a difference of two of them is exact or
// nearly so, and the tests of exact/ err by less than 2^-48 of the distances that occur, a 10^7th of the distance
// between neighbouring places. That takes time, so most particles are told apart before, in single precision: a test
// of a shape at distance d, of size r, errs by less than 2^-20 (d + r) there (at most eight roundings of 2^-24 each),
// and what lies nearer to the surface than that is tested exactly.
#pragma once

#include "shapes/shape.h"
#include "simd/doubles3.h"

namespace motes::MOTES_ISA {

/// More than single precision errs by, as a part of distances and of their squares.
inline constexpr float kRounding = 0x1p-20f;

/// As Hit, for half the lanes. Every path that ends on another side than it begins on is met.
struct Met {
  Longs mask;
  Doubles part;
  Doubles3 normal;
};

// In rare_lanes.cpp. All lanes of places must be numbers of single precision.
/// Where paths meet a shape that has a surface.
Met meet(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to);
/// By the ends of paths, for McAllister's Bounce: planes from both sides, and not through a ball.
Met meet_by_ends(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to);
Mask contains_exactly(const shapes::Shape& shape, const Floats3& p);

}  // namespace motes::MOTES_ISA
