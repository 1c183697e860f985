#include "actions/kernels.h"

#include "simd/builds.h"
#include "simd/isa.h"

namespace motes {

namespace sse2 {
extern const actions::Kernels action_kernels;
}
namespace avx2 {
extern const actions::Kernels action_kernels;
}
namespace avx512 {
extern const actions::Kernels action_kernels;
}

const actions::Kernels& actions::kernels() {
  static const Kernels& chosen = simd::choose<Kernels>(MOTES_BUILDS(action_kernels));
  return chosen;
}

}  // namespace motes
