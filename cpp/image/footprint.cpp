#include "image/footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "image/disc_profile.h"
#include "image/grid.h"
#include "image/layout.h"

namespace motes::image {
namespace {

// The greatest weight: one below 255, which leaves room for rounding up.
constexpr double kPeak = 254;

// Returns the light at (x, y) px from the centre of a disc: flat in the middle, soft at the edge.
double disc_profile(double x, double y, double diameter) {
  const double radius = 0.5 * diameter;
  const double q = (x * x + y * y) / (radius * radius);
  return q < 1 ? DiscProfile::weight(q) : 0;
}

double point_profile(double x, double y) {
  const double across = x < 0 ? 1 + x : 1 - x;
  const double down = y < 0 ? 1 + y : 1 - y;
  return across > 0 && down > 0 ? across * down : 0;
}

// Returns the profile at the footprint's pixels for one phase, row by row.
std::vector<double> sampled(double diameter, int size, double phase_x, double phase_y) {
  std::vector<double> values;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const double x = column + 1 - phase_x - 0.5 * size;
      const double y = row + 1 - phase_y - 0.5 * size;
      values.push_back(diameter > 0 ? disc_profile(x, y, diameter) : point_profile(x, y));
    }
  }
  return values;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// Returns integers in proportion to the values that add up to `total`: the largest remainders are rounded up.
std::vector<int> apportion(const std::vector<double>& values, int total) {
  const double scale = total / sum(values);
  std::vector<int> shares;
  for (const double v : values) shares.push_back(static_cast<int>(v * scale));
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return values[a] * scale - shares[a] > values[b] * scale - shares[b];
  });
  const int missing = total - std::accumulate(shares.begin(), shares.end(), 0);
  for (int i = 0; i < missing; ++i) ++shares[order[static_cast<std::size_t>(i)]];
  return shares;
}

// Builds the footprint of a disc, or of a point if `diameter` is 0. `light`: the sum of its weights; 0: as bright as
// the greatest weight allows.
Footprint build(double diameter, double light = 0) {
  Footprint f;
  f.size = diameter > 0 ? static_cast<int>(std::ceil(diameter)) : 2;
  // Small footprints have fine phases. On a large soft disc steps of a quarter pixel are invisible and save memory.
  f.phase_bits = !(diameter > 0) ? 4 : f.size <= 7 ? 3 : 2;
  f.row_bytes = (3 * f.size + 15) / 16 * 16;
  const int phases = 1 << f.phase_bits;

  std::vector<std::vector<double>> profile;
  double mean = 0;
  for (int y = 0; y < phases; ++y) {
    for (int x = 0; x < phases; ++x) {
      profile.push_back(sampled(diameter, f.size, (x + 0.5) / phases, (y + 0.5) / phases));
      mean += sum(profile.back()) / (phases * phases);
    }
  }
  double highest = 0;
  for (const auto& values : profile) {
    highest = std::max(highest, *std::max_element(values.begin(), values.end()) * (mean / sum(values)));
  }
  const int total = static_cast<int>(light > 0 ? light : mean * (kPeak / highest));

  f.weights.assign(static_cast<std::size_t>(phases * phases * f.size * f.row_bytes), 0);
  std::uint8_t* row = f.weights.data();
  for (std::vector<double>& values : profile) {
    if (light > 0) scale_to(values, total);
    const std::vector<int> shares = apportion(values, total);
    for (int r = 0; r < f.size; ++r, row += f.row_bytes) {
      for (int lane = 0; lane < 3 * f.size; ++lane) {
        row[lane] = static_cast<std::uint8_t>(shares[static_cast<std::size_t>(r * f.size + lane / 3)]);
      }
    }
  }
  return f;
}

}  // namespace

void scale_to(std::vector<double>& weights, double total) {
  for (double limited = 0, before = -1; limited > before;) {
    before = limited;
    double others = 0;
    for (const double w : weights) others += w < kPeak ? w : 0;
    const double scale = others > 0 ? (total - limited) / others : 1;
    limited = 0;
    for (double& w : weights) {
      w = w < kPeak ? std::min(w * scale, kPeak) : kPeak;
      limited += w < kPeak ? 0 : w;
    }
  }
}

int footprint_size(const Sprite& sprite, int height) {
  return static_cast<int>(std::ceil(diameter_of(sprite, height)));
}

const Footprint& footprint(const Sprite& sprite) {
  static const auto all = [] {
    std::array<Footprint, kMaxFootprint + 1> built;
    for (std::size_t pixels = 1; pixels < built.size(); ++pixels) {
      built[pixels] = build(pixels == 1 ? 0 : static_cast<double>(pixels));
    }
    return built;
  }();
  return all[static_cast<std::size_t>(drawn_as_point(sprite) ? 1 : sprite.pixels)];
}

// Interpolates the brightness between the adjacent whole diameters, so a picture is equally bright at any resolution.
Footprint footprint_of(float diameter) {
  const auto per_area = [](int pixels) {
    const Footprint& f = footprint({Sprite::Kind::disc, pixels});
    double sum = 0;
    for (int i = 0; i < f.size * f.row_bytes; ++i) sum += f.weights[static_cast<std::size_t>(i)];
    return sum / 3 / (pixels * pixels);
  };
  const int below = std::min(static_cast<int>(diameter), kMaxFootprint - 1);
  const double part = static_cast<double>(diameter) - below;
  const double light = per_area(below) + (per_area(below + 1) - per_area(below)) * part;
  return build(diameter, light * static_cast<double>(diameter) * static_cast<double>(diameter));
}

} // namespace motes::image
