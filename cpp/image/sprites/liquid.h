// surface: all particles of a system as the smooth skin of a liquid.
#pragma once

#include <tuple>

#include "base/checks.h"
#include "base/members.h"

namespace motes::image {

struct LiquidSprite {
  float radius = 0;  // of a particle, m
  float foam = 0;  // speed at which the liquid is white, m/s; 0: never
  float glass = 1.33f;  // index of refraction

  static constexpr std::tuple kMembers{base::Member{"radius", &LiquidSprite::radius},
                                       base::Member{"foam", &LiquidSprite::foam},
                                       base::Member{"glass", &LiquidSprite::glass}};
  bool operator==(const LiquidSprite&) const = default;
};

inline void check(const LiquidSprite& liquid) {
  base::check_number("sprite.radius", liquid.radius, 1e-9, base::kFarthest);
  base::check_number("sprite.foam", liquid.foam, 0, base::kFarthest);
  base::check_number("sprite.glass", liquid.glass, 1, 4);
}

}  // namespace motes::image
