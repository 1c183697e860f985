// Shapes that are called once per vector instead of being inlined into every loop: however many there are, the code of
// an action that visits shapes grows by only one call.
#pragma once

#include "shapes/all.h"  // written by CMake: all headers of shapes

namespace motes::MOTES_ISA {

struct RareLanes {
  shapes::Kind kind;
  union {
#define MOTES_SHAPE(...)
#define MOTES_RARE_SHAPE(kind, Name, ...) Name##Lanes kind##_lanes;
#include "shapes/list.inc"
  };

  // Defined in rare_lanes.cpp.
  static RareLanes from(const shapes::Shape& shape);
  Mask contains(const Floats3& p) const;
  Mask may_meet(const Floats3& p, const Floats3& to) const;
  Floats3 sample(Draws& draws) const;
  Hit hit(const Floats3& p, const Floats3& path) const;
};

}  // namespace motes::MOTES_ISA
