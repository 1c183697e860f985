// From a shape's kind to its code. A new shape adds its file and one line here, or in rare.h and rare_lanes.cpp.
#pragma once

#include "shapes/box.h"
#include "shapes/disc.h"
#include "shapes/line.h"
#include "shapes/plane.h"
#include "shapes/point.h"
#include "shapes/rare.h"
#include "shapes/rectangle.h"
#include "shapes/sphere.h"

namespace motes::MOTES_ISA {

/// Calls `use` with the shape's lanes: the switch is outside the loop over particles.
template <class Use>
MOTES_INLINE void visit(const shapes::Shape& shape, const Use& use) {
  switch (shape.kind) {
    case shapes::Kind::point: return use(PointLanes::from(shape));
    case shapes::Kind::line: return use(LineLanes::from(shape));
    case shapes::Kind::rectangle: return use(RectangleLanes::from(shape));
    case shapes::Kind::disc: return use(DiscLanes::from(shape));
    case shapes::Kind::plane: return use(PlaneLanes::from(shape));
    case shapes::Kind::box: return use(BoxLanes::from(shape));
    case shapes::Kind::sphere: return use(SphereLanes::from(shape));
    default: return use(RareLanes::from(shape));
  }
}

}  // namespace motes::MOTES_ISA
