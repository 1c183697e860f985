#include "image/light/lamps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "image/curves.h"
#include "image/daylight_parts.h"

namespace motes::image {
namespace {

constexpr double kSoft = 0.9;  // the part of a cone's half angle within which all of its light arrives

// Returns the cosine of an angle of 0..180 degrees.
double cosine_of(double degrees) {
  const double t = tangent(degrees * (std::numbers::pi / 720));  // of a quarter of the angle
  const double c = (1 - t * t) / (1 + t * t);  // of half the angle
  return 2 * c * c - 1;
}

}  // namespace

Lamp lamp_of(const Light& light, const Vector& origin) {
  Lamp lamp{};
  const Vector from = light.position - origin;
  const bool cone = light.spot.degrees > 0;
  const Vector along = cone ? unit(light.spot.direction) : Vector{};
  for (std::size_t i = 0; i < 3; ++i) {
    lamp.position[i] = static_cast<float>(from[i]);
    lamp.color[i] = light.color[i] * light.power;
    lamp.spot[i] = static_cast<float>(along[i]);
  }
  if (!cone || light.spot.degrees >= 360) return lamp;
  const double half = 0.5 * double{light.spot.degrees}, edge = cosine_of(half);
  lamp.cosine = static_cast<float>(edge);
  lamp.per_cosine = static_cast<float>(1 / std::max(cosine_of(kSoft * half) - edge, 1e-9));
  return lamp;
}

Sun sun_of(const View& view) {
  Sun sun;
  sun.shines = length(view.sun) > 0 && view.sun_power > 0;
  if (!sun.shines) return sun;
  const Vector toward = unit(view.sun);
  for (std::size_t i = 0; i < 3; ++i) {
    sun.toward[i] = static_cast<float>(toward[i]);
    sun.color[i] = static_cast<float>(kSun) * view.sun_power * view.sun_color[i];
  }
  return sun;
}

}  // namespace motes::image
