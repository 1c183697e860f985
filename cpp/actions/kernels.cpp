#include "actions/kernels.h"

#include "simd/builds.h"
#include "simd/declare_builds.h"
#include "simd/isa.h"

MOTES_DECLARE_BUILDS(motes::actions::Kernels, action_kernels)

namespace motes::actions {

const Kernels& kernels() {
  static const Kernels& chosen = simd::choose<Kernels>(MOTES_BUILDS(action_kernels));
  return chosen;
}

}  // namespace motes::actions
