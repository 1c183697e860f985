// Shadows of particles: how much light they keep from what is behind them, summed up in a grid in each light's space.
//
// A grid's cells are columns of equal width as the light sees them, in layers across its rays. Particles add optical
// depth to the cells around them, in whole numbers, so that sums do not depend on their order; those much wider than a
// cell add to a coarser level. Resolved, the grid holds the depth from the light to each border between layers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "image/scene.h"

namespace motes::image {

inline constexpr int kShadowColumns = 80;  // along both sides of a grid's finest level
inline constexpr int kShadowLayers = 48;
inline constexpr int kShadowLevels = 4;

/// A grid's space: a point's place in it is (across, upward, ahead) = its offset from `origin` along three unit
/// vectors. Rays of the sun are parallel to `ahead`; those of a point begin at the origin, and columns are of equal
/// tangents.
struct ShadowSpace {
  float origin[3], right[3], up[3], ahead[3];
  bool point = false;
  float first[3]{};   // of the first cell: along right and up, m or tangents; along ahead, m
  float cells[2]{};   // per unit of these: across the rays, along them
};

/// One light's shadows, as kernels take them. Null where it has none.
struct ShadowMap {
  ShadowSpace space;
  const float* depths = nullptr;  // optical depth: kShadowLayers + 1 planes of kShadowColumns^2
};

/// What a grid must hold: the least and greatest place in its space, m; empty where low > high.
struct ShadowExtent {
  std::array<float, 3> low{3e38f, 3e38f, 3e38f}, high{-3e38f, -3e38f, -3e38f};

  bool empty() const { return !(low[0] <= high[0]); }
};

/// The grids of a view's lights: the sun first, then each point, where they shine.
class ShadowGrids {
 public:
  /// Whether any particle of these throws a shadow in the view.
  static bool wanted(const View& view, const std::vector<Sprite>& sprites);

  /// Selects the view's lights; forgets what was summed up.
  void begin(const View& view);

  std::size_t lights() const { return spaces_.size(); }
  const ShadowSpace& space(std::size_t light) const { return spaces_[light]; }
  /// Particles outside this cube do not count: it reaches three times as far around the target as the camera is away.
  const std::array<float, 3>& center() const { return center_; }
  float reach() const { return reach_; }

  /// Lays the grid of a light around its extent; all ranks must give the same.
  void fit(std::size_t light, const ShadowExtent& extent);

  /// Sums of one light, all levels one behind the other; of all lights: lights() times as many.
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

  /// The shadows of the sun; null where it does not shine or nothing throws any. Of a point: its number in the view.
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
  std::vector<int> points_;  // the grid of each of the view's lights; -1: it has none
  int sun_ = -1;
  std::array<float, 3> center_{};
  float reach_ = 0;
};

/// What one particle adds to a cell of its level is at most this, in units of 2^-24 of optical depth.
inline constexpr float kShadowUnit = 16777216.0f;

}  // namespace motes::image
