// The builds of functions_probe.cpp that this process can run.
#pragma once

#include <vector>

#include "simd/builds.h"
#include "simd/declare_builds.h"
#include "support/functions_probe.h"
#include "support/isas.h"

MOTES_DECLARE_BUILDS(test::FunctionsProbe, functions_probe)

namespace test {

inline std::vector<const FunctionsProbe*> function_builds() {
  return runnable<FunctionsProbe>(MOTES_BUILDS(functions_probe));
}

}  // namespace test
