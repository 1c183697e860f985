// Projection from metres to pixels.
#pragma once

#include <optional>
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

/// Returns the camera `back` frames before the picture, interpolated between `before` and the current one. Returns the
/// current one if `before` is not set or the interpolated camera has no direction.
Camera camera_at(const View& view, double back);

/// Returns the camera when the shutter opened: see camera_at().
Lens lens_at_opening(const View& view);

/// Returns the path with that name; "auto" is automatic. Throws std::invalid_argument if there is none.
View::Path path_named(const std::string& name);

/// Why a camera has no direction: the argument, what is allowed, and its value.
struct CameraFault {
  const char* argument;
  const char* allowed;
  Vector got;
};

/// Returns why a camera's directions right and up are undefined, or nothing if they are defined.
std::optional<CameraFault> no_direction(const Camera& camera);

}  // namespace motes::image
