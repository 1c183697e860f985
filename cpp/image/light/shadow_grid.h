// Shadows of particles: how much light they block, summed up in a grid in each light's space.
//
// A grid consists of nested boxes around the camera's target, each with cells twice as wide as those of the box within
// it. Cells are columns along the light's rays, divided into layers across the rays. The cells belong to a lattice that
// is fixed in the world: it depends on the camera and the light, never on the particles. A particle adds optical depth
// to the cells that it covers, in the finest box that contains it and whose cells are not much narrower than it; in
// integers, so sums do not depend on their order. Once resolved, each box holds the light that all particles let
// through to each border between layers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "image/light/depth_map.h"
#include "image/scene.h"

namespace motes::image {

inline constexpr int kShadowColumns = 64;  // along both sides of a box
inline constexpr int kShadowLayers = 64;
inline constexpr int kShadowThick = 2;  // thickness of a layer, in widths of a column
inline constexpr int kShadowBoxes = 4;

/// The space of a grid. Its coordinates (across, upward, ahead) are offsets from `origin` along three unit vectors.
/// Rays of the sun are parallel to `ahead`; those of a point light begin at the origin, and columns have equal
/// tangents.
struct ShadowSpace {
  float origin[3], right[3], up[3], ahead[3];
  bool point = false;
  float cells[2]{};  // of the finest box: per m or tangent across the rays, and per m along them
  float first[kShadowBoxes][3]{};  // first column, row and layer of each box, in its own cells
};

/// The shadows of one light, as kernels read them.
struct ShadowMap {
  ShadowSpace space;
  /// The part of the light that is left: for each box, kShadowLayers + 1 planes of kShadowColumns^2; null: no shadows.
  const float* left = nullptr;
  DepthView sharp;  // of opaque particles
};

/// Returns the distance up to which something keeps the sky's light from surfaces: see View::occlusion, m.
double occlusion_reach(const View& view);

/// The grids of a view's lights that shine: first the sun, then point lights.
class ShadowGrids {
 public:
  /// Returns whether particles of these sprites cast visible shadows in the view.
  static bool wanted(const View& view, const std::vector<Sprite>& sprites);

  /// Selects the view's lights and drops all shadows.
  void begin(const View& view);

  /// The depth maps of the lights, for shadows with edges: add what casts them, then resolve_depths().
  std::vector<DepthMap>& depths() { return depths_; }
  std::vector<DepthMap>& sky_depths() { return sky_depths_; }
  void resolve_depths();

  std::size_t lights() const { return spaces_.size(); }
  const ShadowSpace& space(std::size_t light) const { return spaces_[light]; }

  /// Numbers per layer and per box. The sums of a light are those of its boxes, from the finest on, layer by layer; all
  /// lights have lights() times as many.
  static constexpr std::size_t kLayer = std::size_t{kShadowColumns} * kShadowColumns;
  static constexpr std::size_t kBox = kLayer * kShadowLayers;
  static constexpr std::size_t numbers() { return kBox * kShadowBoxes; }

  /// Turns the sums of all lights into the light that is left. `boxes`: for each light, a bit per box that has any.
  void resolve(const std::vector<std::int64_t>& sums, const std::vector<unsigned>& boxes);

  /// Returns the maps of the sky; null if nothing keeps its light from anything.
  const SkyDepths* of_sky() const { return sky_.part > 0 ? &sky_ : nullptr; }

  /// Return the shadows of the sun, or of a light by its number in the view; null if it does not shine or nothing casts
  /// a shadow.
  const ShadowMap* of_sun() const { return sun_ < 0 ? nullptr : map(static_cast<std::size_t>(sun_)); }
  const ShadowMap* of_light(std::size_t number) const {
    return points_.empty() || points_[number] < 0 ? nullptr : map(static_cast<std::size_t>(points_[number]));
  }

 private:
  void begin_depths(const View& view, double height);
  const ShadowMap* map(std::size_t light) const {
    const ShadowMap& map = maps_[light];
    return map.left == nullptr && map.sharp.texels == nullptr ? nullptr : &map;
  }

  std::vector<ShadowSpace> spaces_;
  std::vector<ShadowMap> maps_;
  std::vector<std::vector<float>> left_;
  std::vector<DepthMap> depths_, sky_depths_;
  SkyDepths sky_;
  float occlusion_ = 0;
  std::vector<int> points_;  // the grid of each of the view's lights; -1: none
  int sun_ = -1;
};

/// An optical depth of 1, in the units of sums.
inline constexpr float kShadowUnit = 16777216.0f;

}  // namespace motes::image
