#include "image/checks.h"

#include <cstdio>
#include <string>

#include "base/checks.h"
#include "base/enumerators.h"
#include "base/vectors.h"
#include "image/camera.h"
#include "image/grid.h"
#include "image/solids.h"

namespace motes::image {
namespace {

using base::check_number;
using base::number_text;

std::string text(const Vector& v) {
  char digits[96];
  std::snprintf(digits, sizeof digits, "(%g, %g, %g)", v[0], v[1], v[2]);
  return digits;
}

void check_size(const char* argument, int pixels) {
  if (pixels < 1 || pixels > kMaxSize) {
    base::refuse(argument, "1.." + std::to_string(kMaxSize), std::to_string(pixels));
  }
}

void check_vector(const std::string& argument, const Vector& v) {
  for (const double x : v) {
    if (!(x >= -base::kFarthest && x <= base::kFarthest)) base::refuse(argument, "finite and within 1e15", text(v));
  }
}

void check_color(const std::string& argument, const Color& c) {
  for (const float x : c) {
    if (!(x >= 0 && x <= base::kFarthest)) base::refuse(argument, "finite and not negative", text({c[0], c[1], c[2]}));
  }
}

void check(const Camera& camera) {
  check_vector("camera.position", camera.position);
  check_vector("camera.look_at", camera.look_at);
  check_vector("camera.up", camera.up);
  if (!(camera.fov_deg > 0 && camera.fov_deg < 180)) {
    base::refuse("camera.fov_deg", "above 0 and below 180", number_text(camera.fov_deg));
  }
  if (!(camera.near > 0 && camera.near <= base::kFarthest))
    base::refuse("camera.near", "above 0 and within 1e15", number_text(camera.near));
  check_number("camera.aperture", camera.aperture, 0, base::kFarthest);
  if (!(camera.focus >= 0 && camera.focus <= base::kFarthest) || (camera.aperture > 0 && !(camera.focus > 0))) {
    base::refuse("camera.focus", "above 0 and within 1e15, in front of the camera", number_text(camera.focus));
  }
  if (const auto fault = no_direction(camera)) base::refuse(fault->argument, fault->allowed, text(fault->got));
}

void check_picture(const std::string& argument, meshes::AssetKey key) {
  if (key == 0 || meshes::has_picture(key)) return;
  base::refuse(argument, "the key of a picture that this process keeps", std::to_string(key));
}

void check(const Sky& sky) {
  if (static_cast<int>(sky.kind) >= base::enumerators<Sky::Kind>()) {
    base::refuse("background", base::names_of<Sky::Kind>(), std::to_string(static_cast<int>(sky.kind)));
  }
  for (const Color& color : {sky.horizon, sky.zenith, sky.ground}) check_color("background", color);
  if (sky.kind == Sky::Kind::picture && sky.picture == 0) base::refuse("background", "a picture", "0");
  check_picture("background", sky.picture);
}

void check(const std::string& argument, const Solid& object) {
  check_color(argument + ".color", object.color);
  check_number(argument + ".light", object.light, 0, base::kFarthest);
  check_number(argument + ".scale", object.scale, 1e-9, base::kFarthest);
  check_picture(argument + ".image", object.image);
  check_number(argument + ".roughness", object.finish.roughness, 0, 1);
  check_number(argument + ".metal", object.finish.metal, 0, 1);
  check_picture(argument + ".finish_image", object.finish_image);
  if (object.glass != 0) check_number(argument + ".glass", object.glass, 1, kMostGlass);
  if (object.mesh == 0) {
    check_solid(argument, object);
  } else if (!meshes::has_mesh(object.mesh)) {
    base::refuse(argument + ".mesh", "the key of a mesh that this process keeps", std::to_string(object.mesh));
  } else if (object.shape.kind == shapes::Kind::mesh) {
    shapes::check_placed(object.shape);
  }
}

void check(const std::string& argument, const Light& light) {
  check_vector(argument + ".position", light.position);
  check_color(argument + ".color", light.color);
  check_number(argument + ".power", light.power, 0, base::kFarthest);
  check_number(argument + ".radius", light.radius, 0, base::kFarthest);
  check_vector(argument + ".spot", light.spot.direction);
  check_number(argument + ".spot", light.spot.degrees, 0, 360);
  if (light.spot.degrees > 0 && !(length(light.spot.direction) > 0)) {
    base::refuse(argument + ".spot", "a direction longer than 0, and degrees", text(light.spot.direction));
  }
}

}  // namespace

void check(const View& view) {
  check_size("width", view.width);
  check_size("height", view.height);
  if (view.full_height != 0) check_size("full_height", view.full_height);
  check(view.camera);
  if (view.before) check(*view.before);
  check_color("background", view.background);
  check(view.sky);
  check_color("fog", view.fog.color);
  check_number("fog", view.fog.metres, 0, base::kFarthest);
  check_number("exposure", view.exposure, 0, base::kFarthest);
  check_vector("sun", view.sun);
  check_color("sun_color", view.sun_color);
  check_number("sun_power", view.sun_power, 0, base::kFarthest);
  check_number("sun_size", view.sun_size, 0, kMostSunSize);
  check_number("shutter", view.shutter, 0, kMostShutter);
  check_number("bloom", view.bloom, 0, 1);
  check_number("occlusion", view.occlusion, 0, 1);
  if (static_cast<int>(view.path) >= base::enumerators<View::Path>()) {
    base::refuse("path", base::names_of<View::Path>(), std::to_string(static_cast<int>(view.path)));
  }
  if (view.layers > kAllLayers) base::refuse("layers", "0..7", std::to_string(view.layers));
  const auto check_each = [](const std::string& list, const auto& all) {
    for (std::size_t i = 0; i < all.size(); ++i) check(list + "[" + std::to_string(i) + "]", all[i]);
  };
  check_each("objects", view.objects);
  check_each("lights", view.lights);
}

}  // namespace motes::image
