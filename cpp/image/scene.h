// What a picture shows and from where: plain values, recorded by the script, equal on every rank.
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
  double focus = 0;     // m to what is sharp; 0: everything is
  double aperture = 0;  // m, the diameter of the lens

  bool operator==(const Camera&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Camera& camera) {
  visit(camera.position, camera.look_at, camera.up, camera.fov_deg, camera.near, camera.focus, camera.aperture);
}

/// An external object (paper 3.2.4): it is drawn and lit, and hides the particles behind it.
struct Solid {
  shapes::Shape shape;
  Color color{1, 1, 1};
  meshes::AssetKey mesh = 0;  // not 0: this mesh instead of the shape; where that is a mesh, it says where this one is
  float light = 0;  // how much of its colour it emits
  meshes::AssetKey image = 0;  // not 0: multiplies its colour, repeated along the world's axes
  float scale = 1;  // m that the image is wide

  bool operator==(const Solid&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Solid& solid) {
  visit(solid.shape, solid.color, solid.mesh, solid.light, solid.image, solid.scale);
}

/// A point that lights the external objects: `power` is the light on a surface that faces it from 1 m.
struct Light {
  Vector position{};
  Color color{1, 1, 1};
  float power = 1;
  float radius = 0;  // m: shadows of solids have soft edges

  bool operator==(const Light&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Light& light) {
  visit(light.position, light.color, light.power, light.radius);
}

/// Bits of View::layers: pictures that are kept beside the frame.
inline constexpr std::uint8_t kDepthLayer = 1;
inline constexpr std::uint8_t kAlphaLayer = 2;
inline constexpr std::uint8_t kVelocityLayer = 4;
inline constexpr std::uint8_t kAllLayers = 7;

/// What is infinitely far where it is not of one colour.
struct Sky {
  /// gradient: mixed by the sine of the height above the horizon. picture: equirectangular, its middle towards -z.
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

/// Haze between the eye and what it sees: exp(-distance / metres) of its light comes through.
struct Fog {
  Color color{};
  float metres = 0;  // 0: there is none

  bool operator==(const Fog&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Fog& fog) {
  visit(fog.color, fog.metres);
}

/// Most of View::shutter.
inline constexpr double kMostShutter = 4;

/// Most of View::sun_size.
inline constexpr double kMostSunSize = 90;

struct View {
  /// Who makes the picture of particles; the pixels are the same in all of them. automatic: chosen for each frame.
  /// gather: the image generator alone (the paper). tiles: each rank draws a part of the picture. composite: each
  /// calculator draws its own particles, and each rank merges a part of the picture.
  enum class Path : std::uint8_t { automatic, gather, tiles, composite };

  int width = 0;  // pixels
  int height = 0;  // pixels
  Camera camera;
  Color background{0, 0, 0};
  Sky sky;  // instead of the background's colour
  Fog fog;
  float exposure = 1;
  std::vector<Solid> objects;
  Vector sun{-0.45, 0.75, 0.55};  // the direction to the sun, of any length; all 0: no sun shines
  float sun_size = 0;  // degrees across: shadows of solids have soft edges
  std::vector<Light> lights;
  Path path = Path::automatic;  // who draws; changes no pixel
  float shutter = 0;  // for how many frames' time it is open, 0..kMostShutter: particles are drawn as streaks
  float bloom = 0;  // part of the light that spreads around what is bright, 0..1
  bool smooth = true;  // edges of objects are anti-aliased
  bool linear = false;  // the picture's light is kept beside its pixels
  std::uint8_t layers = 0;  // kDepthLayer | kAlphaLayer | kVelocityLayer
  std::optional<Camera> before;  // the last frame's camera, where that frame was drawn; the engine fills it in

  bool operator==(const View&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, View& view) {
  visit(view.width, view.height, view.camera, view.background, view.sky, view.fog, view.exposure, view.objects,
        view.sun, view.sun_size, view.lights, view.path, view.shutter, view.bloom, view.smooth, view.linear,
        view.layers, view.before);
}

/// How a sprite's picture is cut into pictures of one size, numbered row by row from the top: the first `count` count.
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

/// Most of Tiles::columns and Tiles::rows.
inline constexpr int kMostTiles = 256;

/// Which tile a particle shows: a number per particle, from 0 on, beyond the last one from the first again. Between
/// two whole numbers it shows a mixture of the two.
struct Pick {
  expressions::Expression number;  // empty: a whole number at random
  std::vector<shapes::Shape> shapes;  // those that it tests

  bool operator==(const Pick&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Pick& pick) {
  visit(pick.number, pick.shapes);
}

/// How the particles of one system are drawn.
struct Sprite {
  /// card: a picture on a plane in space. mesh: an instance of a mesh. ribbon: a band along a particle's last
  /// positions.
  enum class Kind : std::uint8_t { point, disc, sphere, image, card, mesh, ribbon };
  enum class Blend : std::uint8_t { add, alpha, opaque };
  /// Where a card's front looks, and a mesh's: along the particle's velocity, or as its orientation says.
  enum class Facing : std::uint8_t { velocity, orientation };

  Kind kind = Kind::disc;
  int pixels = 5;  // diameter, 1..512; 0: as wide as the particle's size[0], m. Points have no diameter
  Blend blend = Blend::add;
  float of_height = 0;  // above 0: the diameter as a part of the picture's height, instead of `pixels`
  float softness = 0;  // m over which a particle fades where it touches an object
  meshes::AssetKey picture = 0;  // kinds image, card: their picture; mesh: the mesh
  bool lit = false;  // by the sun, lights and sky
  float shadow = 0;  // part of the light that one particle keeps from what lies behind it, 0..1
  Facing facing = Facing::orientation;  // kinds card, mesh
  float width = 0;  // m, of a ribbon at its head
  float length = 0;  // s that a ribbon reaches back
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

/// Positions of a particle that a ribbon may pass through, at most.
inline constexpr std::size_t kMostPast = 16;

/// Where particles were some time ago.
struct Past {
  std::array<const float*, 3> position{};
  float age = 0;  // s
};

/// The columns that drawing needs, as planes of `count` floats. A null plane means that all particles have the value
/// next to it. Planes may be read up to the next multiple of 16 particles.
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
  std::array<Past, kMostPast> past{};  // of ribbons, the latest first
  const float* past_count = nullptr;  // how many of them a particle has; null: none
  const float* tile = nullptr;  // numbers of tiles, as Pick says
  particles::Ids ids;  // these choose tiles at random
};

}  // namespace motes::image
