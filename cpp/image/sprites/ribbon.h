// ribbon: a band along a particle's past positions.
#pragma once

#include <tuple>

#include "base/checks.h"
#include "base/members.h"

namespace motes::image {

struct RibbonSprite {
  float width = 0;       // at its head, m
  float length = 0;      // in seconds of its particle's past

  static constexpr std::tuple kMembers{base::Member{"width", &RibbonSprite::width},
                                       base::Member{"length", &RibbonSprite::length}};
  bool operator==(const RibbonSprite&) const = default;

  /// Returns the part that painters need: records carry everything.
  RibbonSprite painted() const { return {}; }
};

inline void check(const RibbonSprite& ribbon) {
  base::check_number("sprite.width", ribbon.width, 1e-9, base::kFarthest);
  base::check_number("sprite.length", ribbon.length, 1e-9, base::kFarthest);
}

}  // namespace motes::image
