// The contents and the camera of a picture: plain values, recorded by the script, equal on every rank.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/vectors.h"
#include "expressions/expression.h"
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

/// An external object (paper 3.2.4), which is drawn and lit, and hides the particles behind it.
struct Solid {
  shapes::Shape shape;
  Color color{1, 1, 1};
  meshes::AssetKey mesh = 0;  // not 0: drawn instead of `shape`; a shape of kind mesh gives its position and rotation
  float light = 0;  // emitted light, as a multiple of `color`
  meshes::AssetKey image = 0;  // not 0: a picture that multiplies `color`, repeated along the world's axes
  float scale = 1;  // width of the image, m

  bool operator==(const Solid&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Solid& solid) {
  visit(solid.shape, solid.color, solid.mesh, solid.light, solid.image, solid.scale);
}

/// A point light. `power` is the light on a surface that faces it at a distance of 1 m.
struct Light {
  Vector position{};
  Color color{1, 1, 1};
  float power = 1;
  float radius = 0;  // m; above 0: shadows of solids have soft edges

  bool operator==(const Light&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Light& light) {
  visit(light.position, light.color, light.power, light.radius);
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
  float sun_size = 0;  // apparent diameter of the sun, degrees; above 0: shadows of solids have soft edges
  std::vector<Light> lights;
  Path path = Path::automatic;
  float shutter = 0;  // exposure time in frames, 0..kMostShutter; above 0: particles are drawn as streaks
  float bloom = 0;  // fraction of the light that bloom spreads, 0..1
  bool smooth = true;  // edges of objects are anti-aliased
  bool linear = false;  // the picture's linear light is kept in addition to its pixels
  std::uint8_t layers = 0;  // kDepthLayer | kAlphaLayer | kVelocityLayer
  std::optional<Camera> before;  // the previous frame's camera, if that frame was drawn; set by the engine

  bool operator==(const View&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, View& view) {
  visit(view.width, view.height, view.camera, view.background, view.sky, view.fog, view.exposure, view.objects,
        view.sun, view.sun_size, view.lights, view.path, view.shutter, view.bloom, view.smooth, view.linear,
        view.layers, view.before);
}

/// How a sprite's picture is divided into tiles of equal size, numbered row by row from the top; only the first `count`
/// are used.
struct Tiles {
  std::uint16_t columns = 1, rows = 1;
  std::uint32_t count = 1;

  bool cut() const { return count > 1; }
  auto operator<=>(const Tiles&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Tiles& tiles) {
  visit(tiles.columns, tiles.rows, tiles.count);
}

/// Greatest Tiles::columns and Tiles::rows.
inline constexpr int kMostTiles = 256;

/// Which tile each particle shows: a number from 0 on, which wraps around after the last tile. A fraction blends a tile
/// with the next one.
struct Pick {
  expressions::Expression number;  // empty: a random whole number
  std::vector<shapes::Shape> shapes;  // shapes that `number` tests

  bool operator==(const Pick&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Pick& pick) {
  visit(pick.number, pick.shapes);
}

/// How the particles of one system are drawn.
struct Sprite {
  /// card: a picture on a plane in space. mesh: an instance of a mesh. ribbon: a band along a particle's past
  /// positions.
  enum class Kind : std::uint8_t { point, disc, sphere, image, card, mesh, ribbon };
  enum class Blend : std::uint8_t { add, alpha, opaque };
  /// What orients a card or a mesh: the particle's velocity, or its orientation.
  enum class Facing : std::uint8_t { velocity, orientation };

  Kind kind = Kind::disc;
  int pixels = 5;  // diameter, 1..512; 0: the particle's size[0], m. Points have no diameter
  Blend blend = Blend::add;
  float of_height = 0;  // above 0: the diameter as a fraction of the picture's height, instead of `pixels`
  float softness = 0;  // distance, m, over which a particle fades where it touches an object
  meshes::AssetKey picture = 0;  // kinds image and card: the picture; kind mesh: the mesh
  bool lit = false;  // by the sun, lights and sky
  float shadow = 0;  // fraction of the light that one particle blocks, 0..1
  Facing facing = Facing::orientation;  // kinds card, mesh
  float width = 0;  // of a ribbon at its head, m
  float length = 0;  // of a ribbon, in seconds of its particle's past
  bool unfaded = false;  // a ribbon is as opaque at its end as at its head
  Tiles tiles{};  // of `picture`; kinds image, card
  Pick pick{};

  bool operator==(const Sprite&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Sprite& sprite) {
  visit(sprite.kind, sprite.pixels, sprite.blend, sprite.of_height, sprite.softness, sprite.picture, sprite.lit,
        sprite.shadow, sprite.facing, sprite.width, sprite.length, sprite.unfaded, sprite.tiles, sprite.pick);
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
