#include "image/post/bloom_plan.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/invalid_argument.h"

namespace motes::image {
namespace {

// A part of the glow: standard deviation as a fraction of the picture's height, and share of the light that spreads.
struct Glow {
  double radius, share;
};
constexpr std::array<Glow, 3> kGlow{{{0.004, 0.5}, {0.016, 0.3}, {0.064, 0.2}}};

constexpr std::uint64_t kBetween = std::uint64_t{1} << BetweenLanes::kBits;

// Returns exp(-x) for x >= 0 up to about 10, built from + * / only: see curves.h.
double decay(double x) {
  double sum = 1;
  for (int i = 60; i >= 1; --i) sum = 1 + x / i * sum;
  return 1 / sum;
}

// Returns a Gaussian filter whose variance is given in cells squared; its integers add up to 2^16.
Taps gauss(double variance) {
  Taps taps;
  std::array<double, Taps::kMost + 1> weights{1};
  double sum = 1;
  for (int k = 1; k <= Taps::kMost && k * k <= 16 * variance; ++k) {
    taps.reach = k;
    weights[static_cast<std::size_t>(k)] = decay(k * k / (2 * variance));
    sum += 2 * weights[static_cast<std::size_t>(k)];
  }
  taps.taps[0] = std::uint64_t{1} << Taps::kShift;
  for (int k = 1; k <= taps.reach; ++k) {
    const double weight = weights[static_cast<std::size_t>(k)] / sum * (1 << Taps::kShift);
    taps.taps[k] = static_cast<std::uint64_t>(weight + 0.5);
    taps.taps[0] -= 2 * taps.taps[k];
  }
  return taps;
}

// Computes where finer cells lie between the centres of cells. The centre of cell c is at (2 c + 1) fine / cells, in
// halves of finer cells.
void place(BloomAxis& axis) {
  const std::int64_t whole = 2 * std::int64_t{axis.fine};
  for (int i = 0; i < axis.fine; ++i) {
    const std::int64_t at = (2 * std::int64_t{i} + 1) * axis.cells + axis.fine;
    axis.before.push_back(static_cast<int>(at / whole) - 1);
    axis.beyond.push_back(static_cast<std::uint64_t>((at % whole << BetweenLanes::kBits) / whole));
  }
}

// Computes weights that divide each finer cell between the two cells around it, so glow moves smoothly with its light.
void share_out(BloomAxis& axis) {
  const auto cells = static_cast<std::size_t>(axis.cells);
  std::vector<std::vector<std::uint64_t>> shares(cells);
  axis.first.resize(cells);
  for (int i = 0; i < axis.fine; ++i) {
    const int before = axis.before[static_cast<std::size_t>(i)];
    const std::uint64_t beyond = axis.beyond[static_cast<std::size_t>(i)];
    for (const auto& [cell, share] : {std::pair{before, kBetween - beyond}, {before + 1, beyond}}) {
      const auto c = static_cast<std::size_t>(axis.nearest(cell));
      if (share == 0) continue;
      if (shares[c].empty()) axis.first[c] = i;
      shares[c].resize(static_cast<std::size_t>(i - axis.first[c] + 1));
      shares[c].back() += share;
    }
  }
  for (const std::vector<std::uint64_t>& share : shares) {
    const std::uint64_t all = std::accumulate(share.begin(), share.end(), std::uint64_t{0});
    axis.begin.push_back(axis.weights.size());
    std::uint32_t left = 1u << BloomAxis::kWeightBits;
    for (const std::uint64_t one : share) {
      axis.weights.push_back(static_cast<std::uint32_t>((one << BloomAxis::kWeightBits) / all));
      left -= axis.weights.back();
    }
    *std::max_element(axis.weights.begin() + static_cast<std::ptrdiff_t>(axis.begin.back()), axis.weights.end()) +=
        left;
  }
  axis.begin.push_back(axis.weights.size());
}

// Divides an axis into cells of about `cell` px, for a Gaussian of this radius, px. `widened`: the variance, px^2, that
// averaging and enlarging add between the picture and this level; the filter adds the rest.
BloomAxis divided(int pixels, int fine, double cell, double radius, double& widened) {
  BloomAxis axis;
  axis.fine = fine;
  axis.cells = std::clamp(static_cast<int>(pixels / cell), 1, fine);
  if (2 * axis.cells > fine) axis.cells = fine;  // averages of fewer than two would weight them unevenly
  const double side = static_cast<double>(pixels) / axis.cells, part = static_cast<double>(pixels) / fine;
  if (axis.cells != fine) widened += 2 * (side * side / 6 + part * part / 12);
  axis.taps = gauss(std::max(0.0, radius * radius - widened) / (side * side));
  place(axis);
  share_out(axis);
  return axis;
}

// Computes where the lanes of a finer row lie between those of a row of cells.
void spread_lanes(BloomPlan::Level& level) {
  const BloomAxis& across = level.across;
  for (std::size_t i = 0; i < static_cast<std::size_t>(across.fine); ++i) {
    const auto left = static_cast<std::uint32_t>(across.nearest(across.before[i]));
    const auto right = static_cast<std::uint32_t>(across.nearest(across.before[i] + 1));
    for (std::uint32_t c = 0; c < 3; ++c) {
      level.left.push_back(3 * left + c);
      level.right.push_back(3 * right + c);
      level.beyond.push_back(across.beyond[i]);
    }
  }
}

std::array<BloomPlan::Level, 3> levels_of(int width, int height) {
  std::array<BloomPlan::Level, 3> levels;
  double widened_across = 0, widened_down = 0;
  int fine_width = width, fine_height = height;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    BloomPlan::Level& level = levels[i];
    const double radius = kGlow[i].radius * height;
    const double cell = i == 0 ? radius : radius / 2;  // linear interpolation of a wide glow would be visible
    level.across = divided(width, fine_width, cell, radius, widened_across);
    level.down = divided(height, fine_height, cell, radius, widened_down);
    spread_lanes(level);
    fine_width = level.across.cells;
    fine_height = level.down.cells;
  }
  return levels;
}

std::uint32_t parts(float part) { return static_cast<std::uint32_t>(part * 65536.0 + 0.5); }

void around(const BloomAxis& axis, int first, int count, int& cell, int& cells) {
  cell = axis.nearest(axis.before[static_cast<std::size_t>(first)]);
  cells = axis.nearest(axis.before[static_cast<std::size_t>(first + count - 1)] + 1) - cell + 1;
}

}  // namespace

void BloomPlan::make(int new_width, int new_height, float part_of_light) {
  if (new_width < 1 || new_height < 1) throw base::InvalidArgument("a picture with bloom", "have pixels");
  if (!(part_of_light >= 0 && part_of_light <= 1)) throw base::InvalidArgument("bloom", "be in 0..1");
  if (width != new_width || height != new_height) {
    levels = levels_of(new_width, new_height);
    width = new_width;
    height = new_height;
  }
  part = parts(part_of_light);
  std::uint32_t left = part;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i].share = i + 1 == levels.size() ? left : static_cast<std::uint32_t>(part * kGlow[i].share);
    left -= levels[i].share;
  }
}

CellArea BloomPlan::cells(const Area& tile) const {
  CellArea area;
  around(levels[0].across, tile.x, tile.width, area.x, area.width);
  around(levels[0].down, tile.y, tile.height, area.y, area.height);
  return area;
}

}  // namespace motes::image
