// The shapes that are called once a vector instead of being inlined into every loop: an action that visits shapes grows
// by one of them, however many there are.
#pragma once

#include "shapes/blob.h"
#include "shapes/cone.h"
#include "shapes/cylinder.h"
#include "shapes/triangle.h"
#include "shapes/union.h"

namespace motes::MOTES_ISA {

struct RareLanes {
  shapes::Kind kind;
  union {
    TriangleLanes triangle;
    CylinderLanes cylinder;
    ConeLanes cone;
    BlobLanes blob;
    UnionLanes parts;
  };

  // In rare_lanes.cpp.
  static RareLanes from(const shapes::Shape& shape);
  Mask contains(const Floats3& p) const;
  Floats3 sample(Draws& draws) const;
  Hit hit(const Floats3& p, const Floats3& path) const;
};

}  // namespace motes::MOTES_ISA
