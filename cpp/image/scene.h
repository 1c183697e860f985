// What a picture shows and from where: plain values, recorded by the script, equal on every rank.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shapes/shape.h"

namespace motes::image {

using Vector = std::array<double, 3>;  // metres; right-handed, y up
using Color = std::array<float, 3>;    // linear RGB

/// A pinhole camera. `fov_deg` is the vertical angle of view; particles nearer than `near` metres are not drawn.
struct Camera {
  Vector position{0, 0, 1};
  Vector look_at{0, 0, 0};
  Vector up{0, 1, 0};
  double fov_deg = 40;
  double near = 0.1;

  bool operator==(const Camera&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Camera& camera) {
  visit(camera.position, camera.look_at, camera.up, camera.fov_deg, camera.near);
}

/// An external object (paper 3.2.4): it is drawn and lit, and hides the particles behind it.
struct Solid {
  shapes::Shape shape;
  Color color{1, 1, 1};

  bool operator==(const Solid&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Solid& solid) {
  visit(solid.shape, solid.color);
}

struct View {
  int width = 0;   // pixels
  int height = 0;  // pixels
  Camera camera;
  Color background{0, 0, 0};
  float exposure = 1;
  std::vector<Solid> objects;

  bool operator==(const View&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, View& view) {
  visit(view.width, view.height, view.camera, view.background, view.exposure, view.objects);
}

/// How the particles of one system are drawn.
struct Sprite {
  enum class Kind : std::uint8_t { point, disc };
  Kind kind = Kind::disc;
  int pixels = 5;  // diameter of a disc, 1..15

  bool operator==(const Sprite&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Sprite& sprite) {
  visit(sprite.kind, sprite.pixels);
}

/// The columns that drawing needs, as planes of `count` floats. A null plane means that all particles have the value
/// next to it. Planes may be read up to the next multiple of 16 particles.
struct Drawn {
  std::size_t count = 0;
  std::array<const float*, 3> position{};
  std::array<const float*, 3> color{};
  Color color_of_all{1, 1, 1};
  const float* alpha = nullptr;
  float alpha_of_all = 1;
};

}  // namespace motes::image
