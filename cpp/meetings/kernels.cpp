#include "meetings/kernels.h"

#include "simd/builds.h"
#include "simd/isa.h"

namespace motes {

namespace sse2 {
extern const meetings::Kernels meeting_kernels;
}
namespace avx2 {
extern const meetings::Kernels meeting_kernels;
}
namespace avx512 {
extern const meetings::Kernels meeting_kernels;
}

const meetings::Kernels& meetings::kernels() {
  static const Kernels& chosen = simd::choose<Kernels>(MOTES_BUILDS(meeting_kernels));
  return chosen;
}

}  // namespace motes
