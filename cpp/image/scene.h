// The contents and the camera of a picture: plain values, recorded by the script, equal on every rank.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/vectors.h"
#include "image/sprites/sprite.h"
#include "meshes/assets.h"
#include "particles/ids.h"
#include "shapes/shape.h"

namespace motes::image {

using Color = std::array<float, 3>;  // linear RGB

/// A pinhole camera. `fov_deg` is the vertical angle of view; particles nearer than `near` metres are not drawn.
struct Camera {
  Vector position{0, 0, 1};
  Vector look_at{0, 0, 0};
  Vector up{0, 1, 0};
  double fov_deg = 40;
  double near = 0.1;
  double focus = 0;     // distance at which things are sharp, m; 0: everything is sharp
  double aperture = 0;  // diameter of the lens, m

  bool operator==(const Camera&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Camera& camera) {
  visit(camera.position, camera.look_at, camera.up, camera.fov_deg, camera.near, camera.focus, camera.aperture);
}

/// Greatest Solid::glass.
inline constexpr float kMostGlass = 4;

/// An external object (paper 3.2.4), which is drawn and lit, and hides the particles behind it.
struct Solid {
  shapes::Shape shape;
  Color color{1, 1, 1};
  meshes::AssetKey mesh = 0;  // not 0: drawn instead of `shape`; a shape of kind mesh gives its position and rotation
  float light = 0;  // emitted light, as a multiple of `color`
  meshes::AssetKey image = 0;  // not 0: a picture that multiplies `color`, repeated along the world's axes
  float scale = 1;  // width of the image, m
  Finish finish{};
  meshes::AssetKey finish_image = 0;  // not 0: its green multiplies the roughness, its blue the metal, where `image` is
  float glass = 0;  // index of refraction, from 1 on; 0: opaque

  bool operator==(const Solid&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Solid& solid) {
  visit(solid.shape, solid.color, solid.mesh, solid.light, solid.image, solid.scale, solid.finish, solid.finish_image,
        solid.glass);
}

/// A cone of light. Its edge is soft: see Lamp.
struct Spot {
  Vector direction{0, -1, 0};  // of any length
  float degrees = 0;  // angle between opposite sides of the cone, up to 360; 0: the light shines everywhere

  bool operator==(const Spot&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Spot& spot) {
  visit(spot.direction, spot.degrees);
}

/// A point light. `power` is the light on a surface that faces it at a distance of 1 m.
struct Light {
  Vector position{};
  Color color{1, 1, 1};
  float power = 1;
  float radius = 0;  // m; above 0: shadows of solids have soft edges
  Spot spot{};

  bool operator==(const Light&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Light& light) {
  visit(light.position, light.color, light.power, light.radius, light.spot);
}

/// Bits of View::layers: pictures kept in addition to the frame.
inline constexpr std::uint8_t kDepthLayer = 1;
inline constexpr std::uint8_t kAlphaLayer = 2;
inline constexpr std::uint8_t kVelocityLayer = 4;
inline constexpr std::uint8_t kAllLayers = 7;

/// A background of more than one colour, infinitely far away.
struct Sky {
  /// gradient: colours mixed by the sine of the elevation. picture: equirectangular, its centre towards -z.
  enum class Kind : std::uint8_t { none, gradient, picture };

  Kind kind = Kind::none;
  Color horizon{}, zenith{}, ground{};
  meshes::AssetKey picture = 0;

  bool operator==(const Sky&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Sky& sky) {
  visit(sky.kind, sky.horizon, sky.zenith, sky.ground, sky.picture);
}

/// Haze: the fraction exp(-distance / metres) of an object's light reaches the eye.
struct Fog {
  Color color{};
  float metres = 0;  // 0: no fog

  bool operator==(const Fog&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Fog& fog) {
  visit(fog.color, fog.metres);
}

/// Greatest View::shutter.
inline constexpr double kMostShutter = 4;

/// Greatest View::sun_size.
inline constexpr double kMostSunSize = 90;

struct View {
  /// Which ranks draw the particles; the pixels do not depend on it. automatic: chosen for each frame. gather: only the
  /// image generator draws (as in the paper). tiles: each rank draws a part of the picture. composite: each calculator
  /// draws its own particles, and each rank merges a part of the picture.
  enum class Path : std::uint8_t { automatic, gather, tiles, composite };

  int width = 0;  // pixels
  int height = 0;  // pixels
  Camera camera;
  Color background{0, 0, 0};
  Sky sky;  // replaces `background` unless its kind is none
  Fog fog;
  float exposure = 1;
  std::vector<Solid> objects;
  Vector sun{-0.45, 0.75, 0.55};  // direction to the sun, of any length; all 0: no sun
  Color sun_color{1, 1, 1};
  float sun_power = 1;  // factor on the light of the sun, which at 1 gives kSun to a surface that faces it
  float sun_size = 0;  // apparent diameter of the sun, degrees; above 0: shadows of solids have soft edges
  std::vector<Light> lights;
  Path path = Path::automatic;
  float shutter = 0;  // exposure time in frames, 0..kMostShutter; above 0: particles are drawn as streaks
  float bloom = 0;  // fraction of the light that bloom spreads, 0..1
  bool smooth = true;  // edges of objects are anti-aliased
  bool linear = false;  // the picture's linear light is kept in addition to its pixels
  std::uint8_t layers = 0;  // kDepthLayer | kAlphaLayer | kVelocityLayer
  int full_height = 0;  // above 0: a preview of a picture of this height: the diameters of sprites, px, are that one's
  bool bare = false;  // objects and sky give light and hide what is behind them, but are black
  float occlusion = 0;  // part of the sky's light lost where opaque things are near on all sides, 0..1
  std::optional<Camera> before;  // the previous frame's camera, if that frame was drawn; set by the engine

  bool operator==(const View&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, View& view) {
  visit(view.width, view.height, view.camera, view.background, view.sky, view.fog, view.exposure, view.objects,
        view.sun, view.sun_color, view.sun_power, view.sun_size, view.lights, view.path, view.shutter, view.bloom,
        view.smooth, view.linear, view.layers, view.full_height, view.bare, view.before, view.occlusion);
}

/// Greatest number of past positions that a ribbon passes through.
inline constexpr std::size_t kMostPast = 16;

/// The positions of particles `age` seconds ago.
struct Past {
  std::array<const float*, 3> position{};
  float age = 0;
};

/// The columns that drawing needs, as planes of `count` floats. Where a plane is null, all particles have the value
/// `..._of_all`. Planes are readable up to the next multiple of 16 particles.
struct Drawn {
  std::size_t count = 0;
  std::array<const float*, 3> position{};
  std::array<const float*, 3> color{};
  Color color_of_all{1, 1, 1};
  const float* alpha = nullptr;
  float alpha_of_all = 1;
  const float* size = nullptr;  // diameters, m
  float size_of_all = 1;
  std::array<const float*, 3> up{};
  std::array<float, 3> up_of_all{0, 1, 0};
  std::array<const float*, 4> orientation{};
  std::array<float, 4> orientation_of_all{0, 0, 0, 1};
  std::array<const float*, 3> spin{};  // rad/s about the world's axes
  std::array<float, 3> spin_of_all{};
  std::array<const float*, 3> velocity{};  // m/s
  std::array<float, 3> velocity_of_all{};
  std::array<Past, kMostPast> past{};  // for ribbons, latest first
  const float* past_count = nullptr;  // number of valid entries of `past` per particle; null: none
  const float* tile = nullptr;  // tile numbers, see Pick
  particles::Ids ids;  // keys of random tile numbers
};

}  // namespace motes::image
