#include "image/light/sky.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include <vector>

#include "image/curves.h"
#include "image/daylight_parts.h"

namespace motes::image {
namespace {

void put_color(const Color& from, float* to) { std::copy(from.begin(), from.end(), to); }

// Factor on a sky's ambient light, as for a background of one colour: with all of it, the sun would hardly show.
constexpr double kSkyLight = kTint;

// Adds up light from directions.
class SkySum {
 public:
  /// `part`: of all directions; (x, y, z): a unit vector.
  void add(const float* light, double part, double x, double y, double z) {
    const double terms[10] = {1, x, y, z, x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * z * x};
    for (std::size_t i = 0; i < 10; ++i) {
      for (std::size_t c = 0; c < 3; ++c) sums_[i][c] += part * terms[i] * double{light[c]};
    }
  }

  Ambient ambient() const {
    Ambient all;
    all.of_sky = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto term = [&](std::size_t i, double scale) {
        return static_cast<float>(kSkyLight * scale * sums_[i][c]);
      };
      all.mean[c] = term(0, 1);
      for (std::size_t i = 0; i < 3; ++i) all.slope[i][c] = term(1 + i, 2);
      for (std::size_t i = 0; i < 6; ++i) all.curve[i][c] = term(4 + i, 15.0 / 8);
      const float level = 0.375f * all.mean[c] + all.curve[1][c];
      all.low[c] = std::max(level - all.slope[1][c], 0.0f);
      all.high[c] = level + all.slope[1][c];
    }
    return all;
  }

 private:
  double sums_[10][3]{};
};

// Returns the ambient light of a gradient, whose light depends on the sine of the elevation only: at s, the squares of
// the other components have the mean (1 - s^2) / 2.
Ambient of_gradient(const Sky& sky) {
  constexpr int kSteps = 512;
  SkySum sum;
  for (int i = 0; i < kSteps; ++i) {
    const double s = (2 * i + 1.0) / kSteps - 1, up = std::fabs(s), beside = std::sqrt((1 - s * s) / 2);
    const Color& end = s > 0 ? sky.zenith : sky.ground;
    float light[3];
    for (std::size_t c = 0; c < 3; ++c) light[c] = static_cast<float>(sky.horizon[c] * (1 - up) + end[c] * up);
    for (const double x : {-1, 1}) {
      for (const double z : {-1, 1}) sum.add(light, 0.25 / kSteps, x * beside, s, z * beside);
    }
  }
  return sum.ambient();
}

// Returns the sine of the elevation, 1..-1, at `part` of a picture's height from its top.
double height_at(double part) {
  const double angle = (0.5 - part) * std::numbers::pi;
  const double t = tangent(std::fabs(angle) / 2);
  return (angle < 0 ? -2 : 2) * t / (1 + t * t);
}

// Cosine and sine of a turn of `part`, 0..1, from -180 degrees on.
struct Turn {
  double cosine, sine;
};
Turn turn_at(double part) {
  const double angle = (part - 0.5) * 2 * std::numbers::pi, t = tangent(std::fabs(angle) / 4);
  const double c = (1 - t * t) / (1 + t * t), s = 2 * t / (1 + t * t);  // of half the angle
  return {c * c - s * s, (angle < 0 ? -2 : 2) * c * s};
}

// Returns the ambient light of a picture, whose centre is towards -z.
Ambient of_picture(const Texture& picture) {
  int number = 0;
  while (number + 1 < picture.count && picture.levels[number].width > 512) ++number;
  const TextureLevel& level = picture.levels[number];
  std::vector<Turn> columns;
  for (int x = 0; x < level.width; ++x) columns.push_back(turn_at((x + 0.5) / level.width));
  SkySum sum;
  for (int y = 0; y < level.height; ++y) {
    const double first = height_at(static_cast<double>(y) / level.height);
    const double last = height_at(static_cast<double>(y + 1) / level.height);
    const double up = 0.5 * (first + last), aside = std::sqrt(1 - up * up);
    for (int x = 0; x < level.width; ++x) {
      const float* pixel = level.light + 3 * (static_cast<std::ptrdiff_t>(y) * level.width + x);
      const Turn& turn = columns[static_cast<std::size_t>(x)];
      sum.add(pixel, 0.5 * (first - last) / level.width, turn.sine * aside, up, -turn.cosine * aside);
    }
  }
  return sum.ambient();
}

Ambient of_kept_picture(meshes::AssetKey key) {
  static std::mutex mutex;
  static std::map<meshes::AssetKey, Ambient> known;
  const std::scoped_lock lock(mutex);
  const auto found = known.find(key);
  if (found != known.end()) return found->second;
  return known[key] = of_picture(texture(key));
}

}  // namespace

SkyLanes sky_lanes(const View& view) {
  SkyLanes lanes;
  lanes.kind = view.sky.kind;
  put_color(view.background, lanes.color);
  put_color(view.sky.horizon, lanes.horizon);
  put_color(view.sky.zenith, lanes.zenith);
  put_color(view.sky.ground, lanes.ground);
  if (view.sky.kind == Sky::Kind::picture) lanes.picture = texture(view.sky.picture);
  return lanes;
}

Ambient ambient(const View& view) {
  if (view.sky.kind == Sky::Kind::gradient) return of_gradient(view.sky);
  if (view.sky.kind == Sky::Kind::picture) return of_kept_picture(view.sky.picture);
  Ambient all;
  for (std::size_t c = 0; c < 3; ++c) {
    all.low[c] = static_cast<float>(kBounce);
    all.high[c] = static_cast<float>(kSky) + static_cast<float>(kTint) * view.background[c];
  }
  return all;
}

std::array<double, 3> ambient_on(const Ambient& a, const Vector& n) {
  std::array<double, 3> light{};
  const double up = 0.5 + 0.5 * n[1];
  const double terms[6] = {n[0] * n[0], n[1] * n[1], n[2] * n[2], 2 * n[0] * n[1], 2 * n[1] * n[2], 2 * n[2] * n[0]};
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = double{a.low[c]} * (1 - up) + double{a.high[c]} * up;
    if (a.of_sky) {
      sum = 0.375 * double{a.mean[c]};
      for (std::size_t axis = 0; axis < 3; ++axis) sum += double{a.slope[axis][c]} * n[axis];
      for (std::size_t i = 0; i < 6; ++i) sum += double{a.curve[i][c]} * terms[i];
    }
    light[c] = std::max(sum, 0.0);
  }
  return light;
}

}  // namespace motes::image
