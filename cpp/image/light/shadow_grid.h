// Shadows of particles: how much light they block, summed up in a grid in each light's space.
//
// A grid consists of columns along the light's rays, which are divided into layers across the rays. Particles add
// optical depth to the cells around them, in integers, so sums do not depend on their order; particles much wider than
// a cell add to a coarser level. Once resolved, the grid holds the depth from the light to each border between layers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "image/scene.h"

namespace motes::image {

inline constexpr int kShadowColumns = 80;  // along both sides of a grid's finest level
inline constexpr int kShadowLayers = 48;
inline constexpr int kShadowLevels = 4;

/// The space of a grid. Its coordinates (across, upward, ahead) are offsets from `origin` along three unit vectors.
/// Rays of the sun are parallel to `ahead`; those of a point light begin at the origin, and columns have equal
/// tangents.
struct ShadowSpace {
  float origin[3], right[3], up[3], ahead[3];
  bool point = false;
  float first[3]{};   // start of the first cell: along right and up, m or tangents; along ahead, m
  float cells[2]{};   // cells per unit of `first`: across the rays, and along them
};

/// The shadows of one light, as kernels read them.
struct ShadowMap {
  ShadowSpace space;
  const float* depths = nullptr;  // optical depth: kShadowLayers + 1 planes of kShadowColumns^2; null: no shadows
};

/// What a grid must cover: the least and greatest coordinates in its space, m; empty if low > high.
struct ShadowExtent {
  std::array<float, 3> low{3e38f, 3e38f, 3e38f}, high{-3e38f, -3e38f, -3e38f};

  bool empty() const { return !(low[0] <= high[0]); }
};

/// The grids of a view's lights that shine: first the sun, then point lights.
class ShadowGrids {
 public:
  /// Returns whether particles of these sprites cast visible shadows in the view.
  static bool wanted(const View& view, const std::vector<Sprite>& sprites);

  /// Selects the view's lights and drops all shadows.
  void begin(const View& view);

  std::size_t lights() const { return spaces_.size(); }
  const ShadowSpace& space(std::size_t light) const { return spaces_[light]; }
  /// Return the centre and half the side, m, of the cube of particles that cast shadows: the camera's target, and three
  /// times its distance from the camera.
  const std::array<float, 3>& center() const { return center_; }
  float reach() const { return reach_; }

  /// Fits the grid of a light to its extent, which must be the same on all ranks.
  void fit(std::size_t light, const ShadowExtent& extent);

  /// Returns the number of sums of one light, of all levels one after another; all lights have lights() times as many.
  static constexpr std::size_t numbers() {
    std::size_t sum = 0;
    for (int level = 0; level < kShadowLevels; ++level) sum += level_numbers(level);
    return sum;
  }
  static constexpr std::size_t level_numbers(int level) {
    return static_cast<std::size_t>(kShadowColumns >> level) * static_cast<std::size_t>(kShadowColumns >> level) *
           static_cast<std::size_t>(kShadowLayers >> level);
  }

  /// Turns the sums of all lights into depths.
  void resolve(const std::vector<std::int64_t>& sums);

  /// Return the shadows of the sun, or of a light by its number in the view; null if it does not shine or nothing casts
  /// a shadow.
  const ShadowMap* of_sun() const { return sun_ < 0 ? nullptr : map(static_cast<std::size_t>(sun_)); }
  const ShadowMap* of_light(std::size_t number) const {
    return points_.empty() || points_[number] < 0 ? nullptr : map(static_cast<std::size_t>(points_[number]));
  }

 private:
  const ShadowMap* map(std::size_t light) const { return maps_[light].depths == nullptr ? nullptr : &maps_[light]; }

  std::vector<ShadowSpace> spaces_;
  std::vector<char> fitted_;
  std::vector<ShadowMap> maps_;
  std::vector<std::vector<float>> depths_;
  std::vector<int> points_;  // the grid of each of the view's lights; -1: none
  int sun_ = -1;
  std::array<float, 3> center_{};
  float reach_ = 0;
};

/// An optical depth of 1, in the units of sums.
inline constexpr float kShadowUnit = 16777216.0f;

}  // namespace motes::image
