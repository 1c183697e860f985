#include "interactions/kernels.h"

#include "simd/builds.h"
#include "simd/declare_builds.h"
#include "simd/isa.h"

MOTES_DECLARE_BUILDS(motes::interactions::Kernels, interaction_kernels)

namespace motes::interactions {

const Kernels& kernels() {
  static const Kernels& chosen = simd::choose<Kernels>(MOTES_BUILDS(interaction_kernels));
  return chosen;
}

}  // namespace motes::interactions
