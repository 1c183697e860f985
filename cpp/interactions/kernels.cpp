#include "interactions/kernels.h"

#include "simd/builds.h"
#include "simd/isa.h"

namespace motes {

namespace sse2 {
extern const interactions::Kernels meeting_kernels;
}
namespace avx2 {
extern const interactions::Kernels meeting_kernels;
}
namespace avx512 {
extern const interactions::Kernels meeting_kernels;
}

const interactions::Kernels& interactions::kernels() {
  static const Kernels& chosen = simd::choose<Kernels>(MOTES_BUILDS(meeting_kernels));
  return chosen;
}

}  // namespace motes
