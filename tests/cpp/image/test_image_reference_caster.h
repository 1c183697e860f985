// Casts one ray from the camera at the external objects, in double precision: the reference for the scenery. One sun,
// no other lights, no meshes.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "image/camera.h"
#include "image/scene.h"
#include "image/solids.h"
#include "image/test_image_reference_solids.h"

namespace motes::image_test {

using image::Lens;
using image::Solid;
using image::View;

struct Sample {
  Vector light;  // linear RGB
  double depth = std::numeric_limits<double>::infinity();
  std::uint32_t surface = 0;  // differs between two neighbouring pixels if an edge runs between them; 0: background
};

class Caster {
 public:
  /// The view must outlive the caster.
  explicit Caster(const View& view);

  /// Selects a part of the image, in pixels from the top left corner. Returns false if no object is visible there.
  bool aim(double left, double top, double right, double bottom);

  /// Returns what a ray sees at (x, y) pixels from the top left corner, inside the selected part.
  Sample cast(double x, double y) const;

 private:
  struct Item {
    const Solid* solid;
    Ball ball;
    std::uint32_t number;
  };

  bool in_sight(const Ball& ball, double left, double top, double right, double bottom) const;
  double across(double x) const { return (x - 0.5 * view_.width) / lens_.focal_px; }
  double upward(double y) const { return (0.5 * view_.height - y) / lens_.focal_px; }
  Vector shade(const Item& item, const Ray& ray, const Hit& hit, bool& lit) const;
  bool shadowed(const Ray& to_sun, const Item& self) const;
  double bias(const Ray& ray, const Hit& hit) const;

  const View& view_;
  Lens lens_;
  Vector sun_;         // unit vector to the sun
  Vector background_;  // linear RGB
  double fog_square_;  // square of the distance at which half of the light is fog
  std::vector<Item> items_;
  std::vector<const Item*> seen_;  // in the selected part
};

}  // namespace motes::image_test
