#include "image/exposures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/vectors.h"

namespace motes::image {
namespace {

constexpr int kBits = 4;  // of a number below kExposures
static_assert(1 << kBits == kExposures);

// Returns number i of a Sobol sequence, 0..kExposures - 1; `m`: its direction numbers.
int sobol(int i, const std::array<int, kBits>& m) {
  int value = 0;
  for (int bit = 0; bit < kBits; ++bit)
    value ^= (i >> bit & 1) != 0 ? m[static_cast<std::size_t>(bit)] << (kBits - 1 - bit) : 0;
  return value;
}

// Each dimension has one exposure in each sixteenth; the phases divide the sixteenths in different orders.
float place(int i, int phase, const std::array<int, kBits>& m, int turn) {
  const int fine = (phase * (turn % 2 == 0 ? 1 : 3) + turn / 2) % kPhases;
  return (static_cast<float>(sobol(i, m)) + (static_cast<float>(fine) + 0.5f) / kPhases) / kExposures;
}

// Places a point on the lens, in a spiral of golden angles that the phases continue: its points have equal areas.
void put_on_lens(int i, int phase, Exposure& to) {
  constexpr double kCosine = -0.7373688780783197, kSine = 0.6754902942615238;
  double x = std::sqrt((i + (phase + 0.5) / kPhases) / kExposures), y = 0;
  for (int turn = 0; turn < i + phase * kExposures; ++turn) {
    const double turned = x * kCosine - y * kSine;
    y = x * kSine + y * kCosine;
    x = turned;
  }
  to.lens_x = static_cast<float>(x);
  to.lens_y = static_cast<float>(y);
}

shapes::Shape placed_at(const shapes::Shape& mesh, double back) {
  auto numbers = mesh.as<shapes::numbers::mesh>();
  const auto part = static_cast<float>(back);
  for (int i = 0; i < 3; ++i) numbers.end.position[i] += (numbers.start.position[i] - numbers.end.position[i]) * part;
  float cosine = 0, square = 0;
  for (int i = 0; i < 4; ++i) cosine += numbers.end.rotation[i] * numbers.start.rotation[i];
  for (int i = 0; i < 4; ++i) {
    const float start = cosine < 0 ? -numbers.start.rotation[i] : numbers.start.rotation[i];
    numbers.end.rotation[i] += (start - numbers.end.rotation[i]) * part;
    square += numbers.end.rotation[i] * numbers.end.rotation[i];
  }
  if (square > 0) {
    for (float& number : numbers.end.rotation) number /= std::sqrt(square);
  }
  shapes::Shape moved = mesh;
  moved.set(numbers);
  return moved;
}

bool moves(const Solid& solid) { return solid.shape.kind == shapes::Kind::mesh && shapes::changes_place(solid.shape); }

}  // namespace

const Exposures& exposures() {
  static const Exposures all = [] {
    Exposures made{};
    for (int i = 0; i < kExposures; ++i) {
      for (int phase = 0; phase < kPhases; ++phase) {
        Exposure& e = made.of[i][phase];
        e.time = place(i, phase, {1, 3, 3, 9}, 0) - 0.5f;
        put_on_lens(i, phase, e);
        e.pixel_x = place(i, phase, {1, 1, 1, 1}, 1) - 0.5f;
        e.pixel_y = place(i, phase, {1, 3, 5, 15}, 2) - 0.5f;
      }
    }
    return made;
  }();
  return all;
}

bool scenery_blurs(const View& view) {
  if (view.objects.empty() && view.sky.kind == Sky::Kind::none) return false;
  if (view.camera.aperture > 0) return true;
  const bool pans = view.before && *view.before != view.camera;
  return view.shutter > 0 && (pans || std::any_of(view.objects.begin(), view.objects.end(), moves));
}

ExposedView exposed_view(const View& view, const Exposure& exposure) {
  ExposedView seen{view, 0, 0};
  const double back = view.shutter * (0.5 - double{exposure.time});
  seen.view.camera = camera_at(view, back);
  for (Solid& solid : seen.view.objects) {
    if (view.shutter > 0 && moves(solid)) solid.shape = placed_at(solid.shape, back);
  }
  seen.view.before.reset();
  seen.view.shutter = 0;
  Camera& camera = seen.view.camera;
  if (!(camera.aperture > 0)) return seen;
  const Lens through = lens(seen.view);
  const double radius = 0.5 * camera.aperture;
  const Vector aside =
      through.right * (radius * double{exposure.lens_x}) - through.up * (radius * double{exposure.lens_y});
  const auto blur = static_cast<float>(0.5 * blur_of(seen.view));
  camera.position = camera.position + aside;
  camera.look_at = camera.look_at + aside;
  camera.aperture = 0;
  seen.shift_x = exposure.lens_x * blur;
  seen.shift_y = exposure.lens_y * blur;
  return seen;
}

}  // namespace motes::image
