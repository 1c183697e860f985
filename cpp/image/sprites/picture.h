// image, card: sprites that show a picture.
#pragma once

#include <tuple>

#include "base/members.h"
#include "image/sprites/facing.h"
#include "image/sprites/sheet.h"

namespace motes::image {

/// A picture that faces the camera, rotated by the particle's `up`.
struct ImageSprite {
  Sheet sheet;

  static constexpr std::tuple kMembers{base::Member{"sheet", &ImageSprite::sheet}};
  bool operator==(const ImageSprite&) const = default;

  ImageSprite painted() const { return {sheet.painted()}; }
};

inline void check(const ImageSprite& image) { check(image.sheet); }

/// A picture on a plane in space, seen from both sides.
struct CardSprite {
  Sheet sheet;
  Facing facing = Facing::orientation;

  static constexpr std::tuple kMembers{base::Member{"sheet", &CardSprite::sheet},
                                       base::Member{"facing", &CardSprite::facing}};
  bool operator==(const CardSprite&) const = default;

  /// Returns the part that painters need: records carry the rotation.
  CardSprite painted() const { return {sheet.painted()}; }
};

inline void check(const CardSprite& card) { check(card.sheet); }

}  // namespace motes::image
