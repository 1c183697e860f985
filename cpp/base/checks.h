// What the checks of views, sprites, pictures and meshes share.
#pragma once

#include <string>

#include "base/invalid_argument.h"

namespace motes::base {

/// Metres, or whatever else a scene counts: farther than any scene, while its square is still far from infinity.
inline constexpr double kFarthest = 1e15;

[[noreturn]] inline void refuse(const std::string& argument, const std::string& allowed, const std::string& got) {
  throw InvalidArgument(argument, "be " + allowed, got);
}

}  // namespace motes::base
