#include "image/light/shadow_grid.h"

#include <algorithm>
#include <cmath>

#include "base/vectors.h"

namespace motes::image {
namespace {

constexpr double kReach = 3;       // ShadowGrids::reach() in distances from camera to target
constexpr double kWidest = 2;      // tangent of half the greatest angle of a point light's grid
constexpr double kNearest = 0.02;  // least distance at which a point light's grid begins, as a fraction of its end

void put_vector(const Vector& v, float* to) {
  for (std::size_t i = 0; i < 3; ++i) to[i] = static_cast<float>(v[i]);
}

void set_axes(const Vector& ahead, ShadowSpace& space) {
  const Vector side = std::fabs(ahead[1]) < 0.9 ? Vector{0, 1, 0} : Vector{1, 0, 0};
  const Vector right = unit(cross(ahead, side));
  put_vector(ahead, space.ahead);
  put_vector(right, space.right);
  put_vector(cross(right, ahead), space.up);
}

// Rounds a size up to one of a few per octave, so that the grid does not change with each particle that moves.
double stepped(double size) {
  double step = 1;
  while (step > size) step /= 2;
  while (step * 2 <= size) step *= 2;
  for (const double part : {1.0, 1.25, 1.5, 1.75}) {
    if (step * part >= size) return step * part;
  }
  return step * 2;
}

// An axis of cells: the side of a cell, and where the first one begins, which is a multiple of it.
struct AxisOfCells {
  double cell, first;
};
AxisOfCells axis_over(double low, double high, double least, int cells) {
  const double cell = stepped(std::max((high - low) / (cells - 6), least));
  const double middle = 0.5 * (low + high) - 0.5 * cells * cell;
  return {cell, std::floor(middle / cell + 0.5) * cell};
}

std::size_t cell_at(int column, int row, int layer, int columns) {
  return (static_cast<std::size_t>(layer) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(row)) *
             static_cast<std::size_t>(columns) +
         static_cast<std::size_t>(column);
}

// The two cells of the next coarser level whose middles are around that of a cell: the nearer and the farther one.
struct NearbyCells {
  int near, far;
};
NearbyCells nearby(int i, int coarse) {
  const int near = i / 2, far = i % 2 == 0 ? near - 1 : near + 1;
  return {near, std::clamp(far, 0, coarse - 1)};
}

// Adds a coarser level to the next finer one, each of whose layers gets half of the depth.
void refine(const std::vector<float>& coarse, int columns, int layers, std::vector<float>& fine) {
  const int half = columns / 2;
  for (int layer = 0; layer < layers; ++layer) {
    const NearbyCells w = nearby(layer, layers / 2);
    for (int row = 0; row < columns; ++row) {
      const NearbyCells v = nearby(row, half);
      for (int column = 0; column < columns; ++column) {
        const NearbyCells u = nearby(column, half);
        const auto plane = [&](int k) {
          const auto line = [&](int j) {
            return 0.75f * coarse[cell_at(u.near, j, k, half)] + 0.25f * coarse[cell_at(u.far, j, k, half)];
          };
          return 0.75f * line(v.near) + 0.25f * line(v.far);
        };
        fine[cell_at(column, row, layer, columns)] += 0.5f * (0.75f * plane(w.near) + 0.25f * plane(w.far));
      }
    }
  }
}

std::vector<float> level_of(const std::int64_t* sums, int level) {
  std::vector<float> values(ShadowGrids::level_numbers(level));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<float>(static_cast<double>(sums[i]) / double{kShadowUnit});
  }
  return values;
}

// Adds up the depth of layers from the light on.
std::vector<float> depths_of(const std::int64_t* sums) {
  std::array<const std::int64_t*, kShadowLevels> first{sums};
  for (std::size_t i = 1; i < first.size(); ++i) {
    first[i] = first[i - 1] + ShadowGrids::level_numbers(static_cast<int>(i) - 1);
  }
  std::vector<float> values = level_of(first.back(), kShadowLevels - 1);
  for (int level = kShadowLevels - 2; level >= 0; --level) {
    std::vector<float> finer = level_of(first[static_cast<std::size_t>(level)], level);
    refine(values, kShadowColumns >> level, kShadowLayers >> level, finer);
    values = std::move(finer);
  }
  const std::size_t plane = static_cast<std::size_t>(kShadowColumns) * kShadowColumns;
  std::vector<float> depths(plane * (kShadowLayers + 1));
  for (std::size_t i = 0; i < values.size(); ++i) depths[plane + i] = depths[i] + values[i];
  return depths;
}

}  // namespace

bool ShadowGrids::wanted(const View& view, const std::vector<Sprite>& sprites) {
  const bool shines = length(view.sun) > 0 || std::any_of(view.lights.begin(), view.lights.end(),
                                                          [](const Light& light) { return light.power > 0; });
  const bool receives = !view.objects.empty() ||
                        std::any_of(sprites.begin(), sprites.end(), [](const Sprite& sprite) { return sprite.lit; });
  return shines && receives &&
         std::any_of(sprites.begin(), sprites.end(), [](const Sprite& sprite) { return sprite.shadow > 0; });
}

void ShadowGrids::begin(const View& view) {
  spaces_.clear();
  points_.assign(view.lights.size(), -1);
  sun_ = -1;
  const Vector target = view.camera.look_at;
  put_vector(target, center_.data());
  reach_ = static_cast<float>(kReach * length(target - view.camera.position));
  if (length(view.sun) > 0) {
    sun_ = 0;
    ShadowSpace space{};
    put_vector(target, space.origin);
    set_axes(unit(view.sun) * -1.0, space);
    spaces_.push_back(space);
  }
  for (std::size_t i = 0; i < view.lights.size(); ++i) {
    const Light& light = view.lights[i];
    const Vector toward = target - light.position;
    if (!(light.power > 0)) continue;
    points_[i] = static_cast<int>(spaces_.size());
    ShadowSpace space{};
    space.point = true;
    put_vector(light.position, space.origin);
    set_axes(length(toward) > 1e-6 ? unit(toward) : Vector{0, -1, 0}, space);
    spaces_.push_back(space);
  }
  fitted_.assign(spaces_.size(), 0);
  maps_.assign(spaces_.size(), {});
  depths_.assign(spaces_.size(), {});
}

void ShadowGrids::fit(std::size_t light, const ShadowExtent& extent) {
  ShadowSpace& space = spaces_[light];
  const auto number = [](float x) { return static_cast<double>(x); };
  double low[3], high[3];
  for (std::size_t i = 0; i < 3; ++i) low[i] = number(extent.low[i]), high[i] = number(extent.high[i]);
  fitted_[light] = 0;
  if (extent.empty() || (space.point && !(high[2] > 0))) return;
  if (space.point) {
    low[2] = std::max(low[2], kNearest * high[2]);
    for (int i = 0; i < 2; ++i) {  // convert to tangents, as wide as they are anywhere
      low[i] = std::max(low[i] < 0 ? low[i] / low[2] : low[i] / high[2], -kWidest);
      high[i] = std::min(high[i] > 0 ? high[i] / low[2] : high[i] / high[2], kWidest);
    }
  }
  const double least = space.point ? 1e-4 : 1e-5 * number(reach_) + 1e-9;
  const double widest = std::max(high[0] - low[0], high[1] - low[1]);
  for (std::size_t i = 0; i < 2; ++i) {
    const double middle = 0.5 * (low[i] + high[i]);
    const AxisOfCells axis = axis_over(middle - widest / 2, middle + widest / 2, least, kShadowColumns);
    space.first[i] = static_cast<float>(axis.first);
    space.cells[0] = static_cast<float>(1 / axis.cell);
  }
  const AxisOfCells along = axis_over(low[2], high[2], 1e-5 * number(reach_) + 1e-9, kShadowLayers);
  space.first[2] = static_cast<float>(along.first);
  space.cells[1] = static_cast<float>(1 / along.cell);
  fitted_[light] = 1;
}

void ShadowGrids::resolve(const std::vector<std::int64_t>& sums) {
  for (std::size_t light = 0; light < spaces_.size(); ++light) {
    maps_[light] = {};
    if (fitted_[light] == 0) continue;
    depths_[light] = depths_of(sums.data() + light * numbers());
    maps_[light] = {spaces_[light], depths_[light].data()};
  }
}

}  // namespace motes::image
