// The builds of functions_probe.cpp that this processor can run.
#pragma once

#include <vector>

#include "functions_probe.h"
#include "isas.h"

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
  std::vector<const FunctionsProbe*> found;
  for (const Build& build : builds()) {
    found.push_back(build.name == "sse2"   ? &motes::sse2::functions_probe
                    : build.name == "avx2" ? &motes::avx2::functions_probe
                                           : &motes::avx512::functions_probe);
  }
  return found;
}

}  // namespace test
