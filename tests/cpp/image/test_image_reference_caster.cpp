#include "image/test_image_reference_caster.h"

#include <cmath>

#include "base/vectors.h"

namespace motes::image_test {
namespace {

using namespace image;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Light on a surface that faces its source.
constexpr double kSun = 0.70;
constexpr double kSky = 0.24;     // from above
constexpr double kBounce = 0.10;  // from below
constexpr double kTint = 0.5;     // how much of the background's colour the sky adds

constexpr double kFogReach = 5;    // in distances from camera to look_at: where half of the light is fog
constexpr double kBiasPixels = 3;  // how far a resting particle's disc reaches below its centre
constexpr double kLeastBias = 1.0 / 4096;
constexpr double kMostBias = 1.0 / 50;

}  // namespace

Caster::Caster(const View& view)
    : view_(view), lens_(lens(view)), sun_(unit(view.sun)),
      background_{view.background[0], view.background[1], view.background[2]} {
  const double reach = kFogReach * length(view.camera.look_at - view.camera.position);
  fog_square_ = reach * reach;
  for (const Solid& solid : view.objects) {
    items_.push_back({&solid, bounds(solid.shape), static_cast<std::uint32_t>(items_.size())});
  }
}

bool Caster::aim(double left, double top, double right, double bottom) {
  seen_.clear();
  for (const Item& item : items_) {
    if (in_sight(item.ball, across(left), upward(top), across(right), upward(bottom))) seen_.push_back(&item);
  }
  return !seen_.empty();
}

// Bounds are tangents of the angles of view.
bool Caster::in_sight(const Ball& ball, double left, double top, double right, double bottom) const {
  if (ball.radius == kInfinity) return true;
  const Vector center = ball.center - lens_.eye;
  const double depth = dot(center, lens_.forward);
  const double nearest = depth - ball.radius, farthest = depth + ball.radius;
  if (farthest <= view_.camera.near) return false;
  if (nearest <= view_.camera.near) return true;
  // x / z over the cube around the ball.
  const auto least = [&](double x) { return x / (x > 0 ? farthest : nearest); };
  const auto greatest = [&](double x) { return x / (x > 0 ? nearest : farthest); };
  const double x = dot(center, lens_.right), y = dot(center, lens_.up);
  return least(x - ball.radius) <= right && greatest(x + ball.radius) >= left && least(y - ball.radius) <= top &&
         greatest(y + ball.radius) >= bottom;
}

Sample Caster::cast(double x, double y) const {
  // One unit of this direction is one metre of view depth.
  const Ray ray{lens_.eye, lens_.forward + lens_.right * across(x) + lens_.up * upward(y)};
  Sample sample;
  sample.light = background_;
  Hit hit{};
  const Item* nearest = nullptr;
  for (const Item* item : seen_) {
    if (!intersect(item->solid->shape, ray, view_.camera.near, sample.depth, hit)) continue;
    sample.depth = hit.distance;
    nearest = item;
  }
  if (nearest == nullptr) return sample;
  bool lit = false;
  sample.light = shade(*nearest, ray, hit, lit);
  sample.surface = 1 + (nearest->number * 4 + static_cast<std::uint32_t>(hit.face)) * 2 + (lit ? 1 : 0);
  sample.depth *= 1 + bias(ray, hit);
  return sample;
}

Vector Caster::shade(const Item& item, const Ray& ray, const Hit& hit, bool& lit) const {
  const double facing = dot(hit.normal, sun_);
  lit = facing > 0 && !shadowed({ray.from + ray.along * hit.distance, sun_}, item);
  const double up = 0.5 + 0.5 * hit.normal[1];
  const double square = hit.distance * hit.distance * dot(ray.along, ray.along);
  const double fog = square / (square + fog_square_);
  Vector light{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double sky = kBounce + (kSky - kBounce + kTint * background_[c]) * up;
    light[c] = item.solid->color[c] * (sky + (lit ? kSun * facing : 0));
  }
  return light * (1 - fog) + background_ * fog;
}

// Outer surfaces are convex: one that faces the sun is not in the shadow of its own object. (Seen from inside, a box is
// a room without a ceiling, and a pipe lets light in.)
bool Caster::shadowed(const Ray& to_sun, const Item& self) const {
  Hit ignored{};
  for (const Item& item : items_) {
    if (&item == &self) continue;
    if (item.ball.radius != kInfinity) {
      const Vector offset = item.ball.center - to_sun.from;
      const double along = dot(offset, to_sun.along);
      if (along < -item.ball.radius || dot(offset, offset) - along * along > item.ball.radius * item.ball.radius) {
        continue;
      }
    }
    if (intersect(item.solid->shape, to_sun, 1e-6, kInfinity, ignored)) return true;
  }
  return false;
}

// Returns the relative bias: what rests on a surface lies slightly in front of it, the more the steeper the depth
// changes across neighbouring pixels.
double Caster::bias(const Ray& ray, const Hit& hit) const {
  const double across = std::fabs(dot(hit.normal, lens_.right)) + std::fabs(dot(hit.normal, lens_.up));
  const double slope = across / (lens_.focal_px * std::fabs(dot(hit.normal, ray.along)));
  const double wanted = kLeastBias + kBiasPixels * slope;
  return wanted < kMostBias ? wanted : kMostBias;
}

}  // namespace motes::image_test
