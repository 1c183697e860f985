// Helpers for the checks of views, sprites, pictures and meshes.
#pragma once

#include <string>

#include "base/invalid_argument.h"

namespace motes::base {

/// A distance beyond any scene, in its unit (usually metres); its square is still far from float32's infinity.
inline constexpr double kFarthest = 1e15;

[[noreturn]] inline void refuse(const std::string& argument, const std::string& allowed, const std::string& got) {
  throw InvalidArgument(argument, "be " + allowed, got);
}

}  // namespace motes::base
