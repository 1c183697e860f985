// The builds of functions_probe.cpp that this process can run.
#pragma once

#include <vector>

#include "functions_probe.h"
#include "isas.h"
#include "simd/builds.h"

namespace motes {
namespace sse2 {
extern const test::FunctionsProbe functions_probe;
}
namespace avx2 {
extern const test::FunctionsProbe functions_probe;
}
namespace avx512 {
extern const test::FunctionsProbe functions_probe;
}
}  // namespace motes

namespace test {

inline std::vector<const FunctionsProbe*> function_builds() {
  return runnable<FunctionsProbe>(MOTES_BUILDS(functions_probe));
}

}  // namespace test
