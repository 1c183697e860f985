// The objects and lights of a view, prepared for ray casting, and a selection of those that matter for a part of it.
#pragma once

#include <memory>
#include <vector>

#include "image/camera.h"
#include "image/raycast/cast.h"
#include "image/scene.h"
#include "image/solids.h"

namespace motes::image {

class CastScene {
 public:
  /// Throws std::invalid_argument if this process does not keep one of the meshes.
  explicit CastScene(const View& view, const ShadowGrids* shadows = nullptr);

  /// Returns whether the background has more than one colour.
  bool has_sky() const { return view_.sky.kind != Sky::Kind::none && !view_.bare; }

  /// Returns the view with only the objects that may be visible in a part of the image, in px from its top left corner.
  /// Valid until the next call.
  const CastView& aim(double left, double top, double right, double bottom);

  /// Returns the view with only the objects that may shade surfaces within `reach`. Valid until the next call.
  const ShadeView& light(const Reach& reach);

 private:
  // Bounds of an object on the screen, as tangents of the angles of view.
  struct Bounds {
    double left, top, right, bottom;
  };

  void add(const Solid& solid, std::uint32_t number);
  Bounds bounds_on_screen(const Ball& ball) const;
  double across(double x) const { return (x - 0.5 * view_.width) / lens_.focal_px; }
  double upward(double y) const { return (0.5 * view_.height - y) / lens_.focal_px; }

  View view_;
  Lens lens_;
  std::vector<CastSolid> solids_;  // opaque
  std::vector<Ball> balls_;  // of solids_, relative to the eye, like all positions below
  std::vector<Bounds> bounds_;
  std::vector<CastSolid> glass_;
  std::vector<Bounds> glass_bounds_;
  std::vector<std::shared_ptr<const meshes::Bvh>> trees_;  // keeps them alive
  std::vector<Material> materials_;                     // one per object
  bool sunny_;
  Vector sun_;
  double sun_spread_;  // tangent of half the sun's size

  // What aim() and light() selected.
  CastView cast_{};
  ShadeView shade_{};
  std::vector<CastSolid> seen_, before_sun_, around_;
  std::vector<CastLight> lights_;
  std::vector<std::vector<CastSolid>> before_lights_;
};

}  // namespace motes::image
