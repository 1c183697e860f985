// Dispatches from a shape's kind to its code.
#pragma once

#include "shapes/rare.h"

namespace motes::MOTES_ISA {

/// Calls `use` with the shape's lanes: the switch is outside the loop over particles.
template <class Use>
MOTES_INLINE void visit(const shapes::Shape& shape, const Use& use) {
  switch (shape.kind) {
#define MOTES_SHAPE(kind, Name, ...) \
  case shapes::Kind::kind: return use(Name##Lanes::from(shape));
#define MOTES_RARE_SHAPE(kind, ...) \
  case shapes::Kind::kind: break;
#include "shapes/list.inc"
  }
  return use(RareLanes::from(shape));
}

}  // namespace motes::MOTES_ISA
