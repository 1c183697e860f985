// How smooth a surface is, and how much it is a metal.
#pragma once

#include <tuple>

#include "base/members.h"

namespace motes::image {

/// The finish of a surface. With the defaults it scatters light evenly; otherwise it also reflects: see
/// image/light/finish_lanes.h.
struct Finish {
  float roughness = 1;  // 0..1
  float metal = 0;      // 0..1

  static constexpr std::tuple kMembers{base::Member{"roughness", &Finish::roughness},
                                       base::Member{"metal", &Finish::metal}};
  bool operator==(const Finish&) const = default;

  bool reflects() const { return roughness < 1 || metal > 0; }
};

}  // namespace motes::image
