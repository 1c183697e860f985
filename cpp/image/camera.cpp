#include "image/camera.h"

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include "base/checks.h"
#include "base/enumerators.h"
#include "base/vectors.h"
#include "image/curves.h"
#include "image/grid.h"
#include "image/layout.h"
#include "image/mesh_corners.h"
#include "image/solids.h"

namespace motes::image {
namespace {

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

void check_size(const char* argument, int pixels) {
  if (pixels < 1 || pixels > kMaxSize) {
    base::refuse(argument, "1.." + std::to_string(kMaxSize), std::to_string(pixels));
  }
}

void check_vector(const char* argument, const Vector& v) {
  for (const double x : v) {
    if (!(x >= -base::kFarthest && x <= base::kFarthest)) base::refuse(argument, "finite and within 1e15", text(v));
  }
}

void check_color(const std::string& argument, const Color& c) {
  for (const float x : c) {
    if (!(x >= 0 && x <= base::kFarthest)) base::refuse(argument, "finite and not negative", text({c[0], c[1], c[2]}));
  }
}

void check_number(const std::string& argument, double x, double low, double high) {
  if (!(x >= low && x <= high)) base::refuse(argument, text(low) + ".." + text(high), text(x));
}

struct Fault {
  const char* argument;
  const char* allowed;
  Vector got;
};

// Returns why a camera's directions right and up are undefined, or nothing if they are defined.
std::optional<Fault> no_direction(const Camera& camera) {
  const Vector toward = camera.look_at - camera.position;
  if (!(length(toward) > 1e-9)) return Fault{"camera.look_at", "different from camera.position", camera.look_at};
  if (!(length(camera.up) > 1e-9)) return Fault{"camera.up", "longer than 0", camera.up};
  if (length(cross(unit(toward), unit(camera.up))) > 1e-6) return std::nullopt;
  return Fault{"camera.up", "not parallel to the direction of view", camera.up};
}

void check(const Camera& camera) {
  check_vector("camera.position", camera.position);
  check_vector("camera.look_at", camera.look_at);
  check_vector("camera.up", camera.up);
  if (!(camera.fov_deg > 0 && camera.fov_deg < 180)) {
    base::refuse("camera.fov_deg", "above 0 and below 180", text(camera.fov_deg));
  }
  if (!(camera.near > 0 && camera.near <= base::kFarthest))
    base::refuse("camera.near", "above 0 and within 1e15", text(camera.near));
  check_number("camera.aperture", camera.aperture, 0, base::kFarthest);
  if (!(camera.focus >= 0 && camera.focus <= base::kFarthest) || (camera.aperture > 0 && !(camera.focus > 0))) {
    base::refuse("camera.focus", "above 0 and within 1e15, in front of the camera", text(camera.focus));
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

Lens lens_of(const Camera& camera, int height) {
  Lens lens;
  lens.eye = camera.position;
  lens.forward = unit(camera.look_at - camera.position);
  lens.right = unit(cross(lens.forward, camera.up));
  lens.up = cross(lens.right, lens.forward);
  lens.focal_px = 0.5 * height / tangent(camera.fov_deg * (std::numbers::pi / 360));
  return lens;
}

}  // namespace

View::Path path_named(const std::string& name) {
  return name == "auto" ? View::Path::automatic : base::enumerator<View::Path>("path", name);
}

Lens lens(const View& view) { return lens_of(view.camera, view.height); }

double blur_of(const View& view) {
  return view.camera.aperture > 0 ? view.camera.aperture * lens(view).focal_px / view.camera.focus : 0;
}

Lens lens_at_opening(const View& view) {
  if (!view.before) return lens(view);
  const double back = view.shutter;
  const auto between = [&](const auto& now, const auto& before) { return now * (1 - back) + before * back; };
  const Camera &now = view.camera, &before = *view.before;
  Camera camera = now;
  camera.position = between(now.position, before.position);
  camera.look_at = between(now.look_at, before.look_at);
  camera.up = between(unit(now.up), unit(before.up));
  camera.fov_deg =
      now.fov_deg + (before.fov_deg - now.fov_deg) * std::min(back, 1.0);  // beyond 1 it may leave its range
  return lens_of(no_direction(camera) ? now : camera, view.height);
}

void check(const View& view) {
  check_size("width", view.width);
  check_size("height", view.height);
  check(view.camera);
  if (view.before) check(*view.before);
  check_color("background", view.background);
  check(view.sky);
  check_color("fog", view.fog.color);
  check_number("fog", view.fog.metres, 0, base::kFarthest);
  check_number("exposure", view.exposure, 0, base::kFarthest);
  check_vector("sun", view.sun);
  check_number("sun_size", view.sun_size, 0, kMostSunSize);
  check_number("shutter", view.shutter, 0, kMostShutter);
  check_number("bloom", view.bloom, 0, 1);
  if (static_cast<int>(view.path) >= base::enumerators<View::Path>()) {
    base::refuse("path", base::names_of<View::Path>(), std::to_string(static_cast<int>(view.path)));
  }
  if (view.layers > kAllLayers) base::refuse("layers", "0..7", std::to_string(view.layers));
  for (std::size_t i = 0; i < view.objects.size(); ++i) {
    const std::string argument = "objects[" + std::to_string(i) + "]";
    check_color(argument + ".color", view.objects[i].color);
    check_number(argument + ".light", view.objects[i].light, 0, base::kFarthest);
    check_number(argument + ".scale", view.objects[i].scale, 1e-9, base::kFarthest);
    check_picture(argument + ".image", view.objects[i].image);
    if (view.objects[i].mesh == 0) {
      check_solid(argument, view.objects[i]);
    } else if (!meshes::has_mesh(view.objects[i].mesh)) {
      base::refuse(argument + ".mesh", "the key of a mesh that this process keeps",
                   std::to_string(view.objects[i].mesh));
    } else if (view.objects[i].shape.kind == shapes::Kind::mesh) {
      shapes::check_placed(view.objects[i].shape);
    }
  }
  for (std::size_t i = 0; i < view.lights.size(); ++i) {
    const std::string argument = "lights[" + std::to_string(i) + "]";
    check_vector((argument + ".position").c_str(), view.lights[i].position);
    check_color(argument + ".color", view.lights[i].color);
    check_number(argument + ".power", view.lights[i].power, 0, base::kFarthest);
    check_number(argument + ".radius", view.lights[i].radius, 0, base::kFarthest);
  }
}

namespace {

void check_mesh(const Sprite& sprite) {
  if (sprite.pixels != 0 || sprite.of_height > 0) {
    base::refuse("sprite.pixels", "0 for kind mesh: it is scaled by size", std::to_string(sprite.pixels));
  }
  const std::size_t triangles = meshes::mesh(sprite.picture)->triangles.size() / 3;
  if (triangles > kMostSpriteTriangles) {
    base::refuse("sprite.mesh", "of at most " + std::to_string(kMostSpriteTriangles) + " triangles",
                 std::to_string(triangles));
  }
}

void check_ribbon(const Sprite& sprite) {
  check_number("sprite.width", sprite.width, 1e-9, base::kFarthest);
  check_number("sprite.length", sprite.length, 1e-9, base::kFarthest);
  if (sprite.picture != 0) base::refuse("sprite.picture", "0 for kind ribbon", std::to_string(sprite.picture));
}

}  // namespace

bool valid(const Tiles& tiles) {
  if (!tiles.cut()) return tiles == Tiles{};
  const bool within = tiles.columns >= 1 && tiles.columns <= kMostTiles && tiles.rows >= 1 && tiles.rows <= kMostTiles;
  return within && tiles.count <= std::uint32_t{tiles.columns} * tiles.rows;
}

void check(const Sprite& sprite) {
  if (static_cast<int>(sprite.kind) >= base::enumerators<Sprite::Kind>()) {
    base::refuse("sprite.kind", base::names_of<Sprite::Kind>(), std::to_string(static_cast<int>(sprite.kind)));
  }
  if (static_cast<int>(sprite.blend) >= base::enumerators<Sprite::Blend>()) {
    base::refuse("sprite.blend", base::names_of<Sprite::Blend>(), std::to_string(static_cast<int>(sprite.blend)));
  }
  check_number("sprite.of_height", sprite.of_height, 0, 1);
  check_number("sprite.softness", sprite.softness, 0, base::kFarthest);
  check_number("sprite.shadow", sprite.shadow, 0, 1);
  const bool counted_in_pixels = sprite.kind != Sprite::Kind::point && !(sprite.of_height > 0);
  if (counted_in_pixels && (sprite.pixels < 0 || sprite.pixels > kMaxDiameter)) {
    base::refuse("sprite.pixels", "0.." + std::to_string(kMaxDiameter), std::to_string(sprite.pixels));
  }
  if (sprite.kind == Sprite::Kind::ribbon) return check_ribbon(sprite);
  const bool shows = sprite.kind == Sprite::Kind::image || is_posed(sprite);
  if (shows != (sprite.picture != 0)) {
    base::refuse("sprite.picture", "given for kinds image, card and mesh, and for no other",
                 std::to_string(sprite.picture));
  }
  if (sprite.kind == Sprite::Kind::mesh) check_mesh(sprite);
  const Tiles& tiles = sprite.tiles;
  const bool pictures = sprite.kind == Sprite::Kind::image || sprite.kind == Sprite::Kind::card;
  if (!valid(tiles) || (tiles.cut() && !pictures)) {
    base::refuse("sprite.tiles", "1..256 columns and rows of a picture",
                 std::to_string(tiles.columns) + " x " + std::to_string(tiles.rows));
  }
  for (const shapes::Shape& shape : sprite.pick.shapes) shapes::check_region(shape);
}

}  // namespace motes::image
