// Helpers for the checks of views, sprites, pictures and meshes.
#pragma once

#include <cstdio>
#include <string>

#include "base/invalid_argument.h"

namespace motes::base {

/// A distance beyond any scene, in its unit (usually metres); its square is still far from float32's infinity.
inline constexpr double kFarthest = 1e15;

[[noreturn]] inline void refuse(const std::string& argument, const std::string& allowed, const std::string& got) {
  throw InvalidArgument(argument, "be " + allowed, got);
}

inline std::string number_text(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%g", value);
  return digits;
}

inline void check_number(const std::string& argument, double x, double low, double high) {
  if (!(x >= low && x <= high)) refuse(argument, number_text(low) + ".." + number_text(high), number_text(x));
}

}  // namespace motes::base
