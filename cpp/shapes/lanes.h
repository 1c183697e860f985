// What the files of all shapes share. Each shape has one file, with functions for one vector of particles at a time.
#pragma once

#include "particles/random.h"
#include "shapes/exact.h"
#include "shapes/shape.h"
#include "simd/elementary.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// Where a path meets a surface: the lanes that do, the fraction (0..1) of the path before the hit, and the unit normal
/// that points back along the path.
struct Hit {
  Mask mask;
  Floats part;
  Floats3 normal;
};

MOTES_INLINE Hit no_hit() { return {Mask{}, Floats{}, {Floats{}, Floats{}, Floats{}}}; }

}  // namespace motes::MOTES_ISA
