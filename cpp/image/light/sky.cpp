#include "image/light/sky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>

#include "image/curves.h"
#include "image/daylight_parts.h"

namespace motes::image {
namespace {

using LightSum = std::array<double, 3>;

void put_color(const Color& from, float* to) { std::copy(from.begin(), from.end(), to); }

// Factor on a sky's ambient light, as for a background of one colour: with all of it, the sun would hardly show.
constexpr auto kSkyLight = static_cast<float>(kTint);

// Returns the ambient light of a gradient: its mean over each half of the sky, weighted for a surface that faces up or
// down by 2 s ds, where s is the sine of the elevation.
Ambient of_gradient(const Sky& sky) {
  Ambient all;
  for (std::size_t c = 0; c < 3; ++c) {
    all.high[c] = kSkyLight * (sky.horizon[c] + 2 * sky.zenith[c]) / 3;
    all.low[c] = kSkyLight * (sky.horizon[c] + 2 * sky.ground[c]) / 3;
  }
  return all;
}

// Returns the sine of the elevation, 1..-1, at `part` of a picture's height from its top.
double height_at(double part) {
  const double angle = (0.5 - part) * std::numbers::pi;
  const double t = tangent(std::fabs(angle) / 2);
  return (angle < 0 ? -2 : 2) * t / (1 + t * t);
}

// Returns the ambient light of a picture. A row's weight is the integral of 2 s ds, where s is the sine of the
// elevation.
Ambient of_picture(const Texture& picture) {
  int number = 0;
  while (number + 1 < picture.count && picture.levels[number].width > 512) ++number;
  const TextureLevel& level = picture.levels[number];
  LightSum up{}, down{};
  double above = 0, below = 0;
  for (int y = 0; y < level.height; ++y) {
    const double first = height_at(static_cast<double>(y) / level.height);
    const double last = height_at(static_cast<double>(y + 1) / level.height);
    LightSum mean{};
    for (int x = 0; x < level.width; ++x) {
      const float* pixel = level.light + 3 * (static_cast<std::ptrdiff_t>(y) * level.width + x);
      for (std::size_t c = 0; c < 3; ++c) mean[c] += double{pixel[c]} / level.width;
    }
    const double over = std::max(first, 0.0), under = std::max(last, 0.0);
    const double lifted = over * over - under * under;
    const double least = std::min(last, 0.0), greatest = std::min(first, 0.0);
    const double sunk = least * least - greatest * greatest;
    above += lifted;
    below += sunk;
    for (std::size_t c = 0; c < 3; ++c) {
      up[c] += lifted * mean[c];
      down[c] += sunk * mean[c];
    }
  }
  Ambient all;
  for (std::size_t c = 0; c < 3; ++c) {
    all.high[c] = kSkyLight * static_cast<float>(above > 0 ? up[c] / above : 0);
    all.low[c] = kSkyLight * static_cast<float>(below > 0 ? down[c] / below : 0);
  }
  return all;
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
  if (view.sky.kind == Sky::Kind::picture) lanes.picture = texture(view.sky.picture).levels[0];
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

}  // namespace motes::image
