// The light on spheres: the sun and the sky.
#pragma once

#include <cmath>

#include "base/vectors.h"
#include "image/camera.h"
#include "image/daylight_parts.h"
#include "image/light/sky.h"
#include "image/scene.h"

namespace motes::image {

/// The shade of a sphere that is not lit (see Sprite::lit) as a function of its surface's normal: the light on solids
/// without lamps, shadows and colour, so one number per pixel is enough.
class Daylight {
 public:
  explicit Daylight(const View& view) : sun_(length(view.sun) > 0 ? unit(view.sun) : Vector{}) {
    const auto mean = [](const auto& color) { return (double{color[0]} + color[1] + color[2]) / 3; };
    sun_power_ = kSun * view.sun_power * mean(view.sun_color);
    const Lens l = lens(view);
    right_ = l.right;
    up_ = l.up;
    back_ = l.forward * -1.0;
    low_ = kBounce;
    high_ = kSky + kTint * mean(view.background);
    if (view.sky.kind != Sky::Kind::none) {
      const Ambient sky = ambient(view);
      low_ = mean(sky.low);
      high_ = mean(sky.high);
    }
    // In the camera's axes: x to the right, y up and z to the camera.
    toward_sun_ = {dot(right_, sun_), dot(up_, sun_), dot(back_, sun_)};
    upward_ = {right_[1], up_[1], back_[1]};
  }

  /// Returns the shade, 0..1, where the unit normal in the camera's axes is `normal`.
  double shade(const Vector& normal) const {
    const double facing = dot(normal, toward_sun_);
    const double shade =
        low_ + (high_ - low_) * (0.5 + 0.5 * dot(normal, upward_)) + (facing > 0 ? sun_power_ * facing : 0);
    return shade < 1 ? shade : 1;
  }

  /// Parameters of shade() for kernels, see raster/kind_sphere.h.
  const Vector& toward_sun() const { return toward_sun_; }
  const Vector& upward() const { return upward_; }
  double sun() const { return sun_power_; }
  double low() const { return low_; }
  double high() const { return high_; }

 private:
  Vector sun_, right_, up_, back_, toward_sun_, upward_;
  double sun_power_, low_, high_;
};

}  // namespace motes::image
