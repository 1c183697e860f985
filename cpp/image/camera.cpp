#include "image/camera.h"

#include <cstdio>
#include <stdexcept>
#include <string>

#include "image/curves.h"
#include "image/grid.h"
#include "image/solids.h"
#include "image/vectors.h"

namespace motes::image {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Farther than any scene, while its square is still far from infinity.
constexpr double kFarthest = 1e15;

std::string text(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%g", value);
  return digits;
}
std::string text(const Vector& v) {
  char digits[96];
  std::snprintf(digits, sizeof digits, "(%g, %g, %g)", v[0], v[1], v[2]);
  return digits;
}

[[noreturn]] void refuse(const std::string& argument, const std::string& allowed, const std::string& got) {
  throw std::invalid_argument(argument + " must be " + allowed + ", got " + got);
}

void check_size(const char* argument, int pixels) {
  if (pixels < 1 || pixels > kMaxSize) {
    refuse(argument, "1.." + std::to_string(kMaxSize), std::to_string(pixels));
  }
}

void check_vector(const char* argument, const Vector& v) {
  for (const double x : v) {
    if (!(x >= -kFarthest && x <= kFarthest)) refuse(argument, "finite and within 1e15", text(v));
  }
}

void check_color(const std::string& argument, const Color& c) {
  for (const float x : c) {
    if (!(x >= 0 && x <= 1e15f)) refuse(argument, "finite and not negative", text({c[0], c[1], c[2]}));
  }
}

void check(const Camera& camera) {
  check_vector("camera.position", camera.position);
  check_vector("camera.look_at", camera.look_at);
  check_vector("camera.up", camera.up);
  if (!(camera.fov_deg > 0 && camera.fov_deg < 180)) {
    refuse("camera.fov_deg", "above 0 and below 180", text(camera.fov_deg));
  }
  if (!(camera.near > 0 && camera.near <= kFarthest)) refuse("camera.near", "above 0", text(camera.near));
  const Vector toward = camera.look_at - camera.position;
  if (!(length(toward) > 1e-9)) refuse("camera.look_at", "apart from camera.position", text(camera.look_at));
  if (!(length(camera.up) > 1e-9)) refuse("camera.up", "longer than 0", text(camera.up));
  if (!(length(cross(unit(toward), unit(camera.up))) > 1e-6)) {
    refuse("camera.up", "not parallel to the direction of view", text(camera.up));
  }
}

}  // namespace

Lens lens(const View& view) {
  const Camera& camera = view.camera;
  Lens lens;
  lens.eye = camera.position;
  lens.forward = unit(camera.look_at - camera.position);
  lens.right = unit(cross(lens.forward, camera.up));
  lens.up = cross(lens.right, lens.forward);
  lens.focal_px = 0.5 * view.height / tangent(camera.fov_deg * (kPi / 360));
  return lens;
}

void check(const View& view) {
  check_size("width", view.width);
  check_size("height", view.height);
  check(view.camera);
  check_color("background", view.background);
  if (!(view.exposure > 0 && view.exposure <= 1e15f)) refuse("exposure", "finite and above 0", text(view.exposure));
  for (std::size_t i = 0; i < view.objects.size(); ++i) {
    const std::string argument = "objects[" + std::to_string(i) + "]";
    check_color(argument + ".color", view.objects[i].color);
    check_solid(argument, view.objects[i]);
  }
}

void check(const Sprite& sprite) {
  if (sprite.kind != Sprite::Kind::point && sprite.kind != Sprite::Kind::disc) {
    refuse("sprite.kind", "point or disc", std::to_string(static_cast<int>(sprite.kind)));
  }
  if (sprite.kind == Sprite::Kind::disc && (sprite.pixels < 1 || sprite.pixels > kMaxFootprint)) {
    refuse("sprite.pixels", "1.." + std::to_string(kMaxFootprint), std::to_string(sprite.pixels));
  }
}

}  // namespace motes::image
