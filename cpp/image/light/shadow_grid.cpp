#include "image/light/shadow_grid.h"

#include <algorithm>
#include <cmath>

#include "base/vectors.h"
#include "image/camera.h"
#include "image/light/lamps.h"
#include "image/light/shadow_boxes.h"

namespace motes::image {
namespace {

constexpr double kFinest = 0.8;  // side of the finest box, in heights of the picture at the camera's target

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

// Rounds a size up to one of a few per octave, so that the lattice stays the same while the camera moves a little.
double stepped(double size) {
  double step = 1;
  while (step > size) step /= 2;
  while (step * 2 <= size) step *= 2;
  for (const double part : {1.0, 1.25, 1.5, 1.75}) {
    if (step * part >= size) return step * part;
  }
  return step * 2;
}

// Places boxes around a point, `at` cells of the finest box along each axis. Boxes begin at even cells, so that their
// cells are halves of those of the next coarser box.
void place_boxes(const std::array<double, 3>& at, ShadowSpace& space) {
  constexpr int kSides[3] = {kShadowColumns, kShadowColumns, kShadowLayers};
  double scale = 1;
  for (auto& first : space.first) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis] = static_cast<float>(2 * std::floor((at[axis] * scale - 0.5 * kSides[axis]) / 2 + 0.5));
    }
    scale /= 2;
  }
}

}  // namespace

bool ShadowGrids::wanted(const View& view, const std::vector<Sprite>& sprites) {
  const bool shines = sun_of(view).shines || std::any_of(view.lights.begin(), view.lights.end(),
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
  const double height = view.height / lens(view).focal_px * length(target - view.camera.position);
  const double cell = std::max(stepped(kFinest * height / kShadowColumns), 1e-9);
  if (sun_of(view).shines) {
    sun_ = 0;
    ShadowSpace space{};
    const Vector ahead = unit(view.sun) * -1.0;
    set_axes(ahead, space);
    space.cells[0] = static_cast<float>(1 / cell);
    space.cells[1] = space.cells[0] / kShadowThick;
    // The origin is near the target, for precision, at a corner of a cell of the coarsest box.
    const double step = cell * (kShadowThick << kShadowBoxes);
    Vector origin{};
    std::array<double, 3> at{};
    std::size_t axis = 0;
    for (const Vector& along : {vector_of(space.right), vector_of(space.up), vector_of(space.ahead)}) {
      const double place = dot(target, along), corner = std::floor(place / step) * step;
      origin = origin + along * corner;
      at[axis] = (place - corner) / (axis == 2 ? kShadowThick * cell : cell);
      ++axis;
    }
    put_vector(origin, space.origin);
    place_boxes(at, space);
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
    const double far = std::max(length(toward), cell);
    set_axes(length(toward) > 1e-6 ? unit(toward) : Vector{0, -1, 0}, space);
    space.cells[0] = static_cast<float>(far / cell);
    space.cells[1] = static_cast<float>(1 / (kShadowThick * cell));
    place_boxes({0, 0, far / (kShadowThick * cell)}, space);
    spaces_.push_back(space);
  }
  maps_.assign(spaces_.size(), {});
  left_.resize(spaces_.size());
}

void ShadowGrids::resolve(const std::vector<std::int64_t>& sums, const std::vector<unsigned>& boxes) {
  for (std::size_t light = 0; light < spaces_.size(); ++light) {
    set_light_left(spaces_[light], sums.data() + light * numbers(), boxes[light], left_[light]);
    maps_[light] = {};
    if (!left_[light].empty()) maps_[light] = {spaces_[light], left_[light].data()};
  }
}

}  // namespace motes::image
