// Three components and one more number per lane, in vectors and as they lie in memory.
#pragma once

#include "simd/floats3.h"
#include "simd/quads.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats3 three(const FourWords& v) { return {(Floats)v.word[0], (Floats)v.word[1], (Floats)v.word[2]}; }
MOTES_INLINE Floats fourth(const FourWords& v) { return (Floats)v.word[3]; }

MOTES_INLINE Quads quads_of(const Floats3& v, Floats last) {
  return quads_of((Uints)v.x, (Uints)v.y, (Uints)v.z, (Uints)last);
}

/// Four numbers of one lane.
using Four = float __attribute__((vector_size(16)));
MOTES_INLINE Four load_four(const float* from) {
  Four v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}

}  // namespace motes::MOTES_ISA
