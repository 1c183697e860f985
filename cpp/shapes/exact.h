// Exact tests of which side of a surface places are on and where paths meet it, so rounding cannot move a particle to
// the other side.
//
// Places and numbers of shapes have single precision. In double precision, a difference of two of them is exact or
// nearly so, and the tests in exact_*.h err by less than 2^-48 of the distances involved, a 10^7th of the distance
// between neighbouring places. That takes time, so most particles are decided in single precision first: there a test
// of a shape of size r at distance d errs by less than 2^-20 (d + r) (at most eight roundings of 2^-24 each), and only
// places nearer to the surface than that are tested exactly.
#pragma once

#include "shapes/shape.h"
#include "simd/doubles3.h"

namespace motes::MOTES_ISA {

/// Upper bound of the error of single precision, relative to distances and to their squares.
inline constexpr float kRounding = 0x1p-20f;

/// Like Hit, for half the lanes. The mask includes every path that ends on a different side than it starts on.
struct Met {
  Longs mask;
  Doubles part;
  Doubles3 normal;
};

// Defined in rare_lanes.cpp. All lanes of places must be numbers of single precision.
/// Returns where paths meet a shape that has a surface.
Met meet(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to);
/// Like meet(), but decides by the ends of paths, for McAllister's Bounce: planes are met from both sides, and a ball
/// is not met by paths through it.
Met meet_by_ends(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to);
Mask contains_exactly(const shapes::Shape& shape, const Floats3& p);

}  // namespace motes::MOTES_ISA
