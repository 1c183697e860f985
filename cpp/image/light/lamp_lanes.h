// The light of lamps. Compiled once for each instruction set.
#pragma once

#include "image/light/lamps.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// Returns the part of a lamp's light that its cone lets through. `along`: from the lit place to the lamp; `square`: of
/// its length.
MOTES_INLINE Floats in_cone(const image::Lamp& lamp, Floats3 along, Floats square) {
  const Floats cosine = -dot(along, all3(lamp.spot)) / sqrt(max(square, all(1e-30f)));
  const Floats part = min(max((cosine - lamp.cosine) * lamp.per_cosine, Floats{}), all(1.0f));
  return part * part * (3.0f - 2.0f * part);
}

}  // namespace motes::MOTES_ISA
