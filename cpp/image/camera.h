// From metres to pixels; and what a view may contain.
#pragma once

#include <string>

#include "image/scene.h"

namespace motes::image {

/// A camera prepared for an image: a point p has view depth z = forward.(p - eye) and appears at x = width/2 + focal_px
/// right.(p - eye)/z, y = height/2 - focal_px up.(p - eye)/z pixels from the top left corner.
struct Lens {
  Vector eye, right, up, forward;  // metres; three unit vectors
  double focal_px = 0;
};

Lens lens(const View& view);

/// How wide a lens makes a point that is infinitely far, px; 0: it is sharp.
double blur_of(const View& view);

/// The camera when the shutter opened: on its way from `before` to where it is now. Where there was no last frame, or
/// the way between passes through an impossible camera, the camera did not move.
Lens lens_at_opening(const View& view);

/// The way to make pictures with that name; "auto" is automatic. Throws std::invalid_argument where there is none.
View::Path path_named(const std::string& name);

/// Throw std::invalid_argument, naming the argument, its value and what is allowed.
void check(const View& view);
void check(const Sprite& sprite);

/// Tells whether there are as many columns and rows as may be, and a tile for each number; where there is one, no more.
bool valid(const Tiles& tiles);

}  // namespace motes::image
