// Projection from metres to pixels, and checks of views and sprites.
#pragma once

#include <string>

#include "image/scene.h"

namespace motes::image {

/// A camera prepared for an image: a point p has view depth z = forward.(p - eye) and appears at x = width/2 + focal_px
/// right.(p - eye)/z, y = height/2 - focal_px up.(p - eye)/z pixels from the top left corner.
struct Lens {
  Vector eye, right, up, forward;  // eye: m; the others: unit vectors
  double focal_px = 0;
};

Lens lens(const View& view);

/// Returns the diameter, px, of the lens blur of a point at infinity; 0 if everything is sharp.
double blur_of(const View& view);

/// Returns the camera when the shutter opened, interpolated between `before` and the current one. Returns the current
/// one if `before` is not set or the interpolated camera has no direction.
Lens lens_at_opening(const View& view);

/// Returns the path with that name; "auto" is automatic. Throws std::invalid_argument if there is none.
View::Path path_named(const std::string& name);

/// Checks a view or a sprite; throws std::invalid_argument naming the argument, its value and what is allowed.
void check(const View& view);
void check(const Sprite& sprite);

/// Returns whether columns and rows are within their limits and hold `count` tiles. A picture that is not divided must
/// have one column and one row.
bool valid(const Tiles& tiles);

}  // namespace motes::image
