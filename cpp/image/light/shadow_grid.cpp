#include "image/light/shadow_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/vectors.h"
#include "image/camera.h"
#include "image/curves.h"
#include "image/light/lamps.h"
#include "image/light/shadow_boxes.h"

namespace motes::image {
namespace {

// Texels of depth maps in the height of the picture at the camera's target: of suns, and of directions of the sky; and
// the part of this height in which particles and solids keep the sky's light from others.
constexpr double kTexelsInHeight = 820, kSkyTexelsInHeight = 205, kReach = 0.15;
constexpr double kGoldenCosine = -0.7373688780783197, kGoldenSine = 0.6754902942615238;
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

// Returns the space of the map of a sun with texels of this width, m. `size`: tangent of half its angular diameter.
DepthSpace sun_space(const View& view, const Vector& toward, double texel, double size) {
  ShadowSpace axes{};
  set_axes(unit(toward) * -1.0, axes);
  DepthSpace space{};
  std::copy_n(axes.right, 3, space.right);
  std::copy_n(axes.up, 3, space.up);
  std::copy_n(axes.ahead, 3, space.ahead);
  space.texels = static_cast<float>(1 / texel);
  space.size = static_cast<float>(size);
  // The origin is near the target, for precision, at a corner of texels of all planes.
  const double step = texel * (2 << kSunPlanes);
  Vector origin{};
  std::array<double, 3> at{};
  std::size_t axis = 0;
  for (const Vector& along : {vector_of(space.right), vector_of(space.up), vector_of(space.ahead)}) {
    const double place = dot(view.camera.look_at, along), corner = std::floor(place / step) * step;
    origin = origin + along * corner;
    at[axis++] = (place - corner) / texel;
  }
  put_vector(origin, space.origin);
  double scale = 1;
  for (auto& first : space.first) {
    for (std::size_t i = 0; i < 2; ++i) {
      first[i] = static_cast<float>(2 * std::floor((at[i] * scale - 0.5 * kDepthSide) / 2));
    }
    scale /= 2;
  }
  return space;
}

// Returns the height of the picture at the camera's target, m.
double height_at_target(const View& view) {
  return view.height / lens(view).focal_px * length(view.camera.look_at - view.camera.position);
}

}  // namespace

bool ShadowGrids::wanted(const View& view, const std::vector<Sprite>& sprites) {
  const bool shines = sun_of(view).shines || std::any_of(view.lights.begin(), view.lights.end(),
                                                         [](const Light& light) { return light.power > 0; });
  const bool receives = !view.objects.empty() ||
                        std::any_of(sprites.begin(), sprites.end(), [](const Sprite& sprite) { return sprite.lit; });
  const bool covers = view.occlusion > 0 && std::any_of(sprites.begin(), sprites.end(), covers_sky);
  return receives && (covers || (shines && std::any_of(sprites.begin(), sprites.end(),
                                                       [](const Sprite& sprite) { return sprite.shadow > 0; })));
}

double occlusion_reach(const View& view) { return kReach * height_at_target(view); }

void ShadowGrids::begin_depths(const View& view, double height) {
  const auto texel = [&](double in_height) { return std::max(stepped(height / in_height), 1e-9); };
  if (sun_ >= 0) {
    const double size = tangent(double{view.sun_size} * (std::numbers::pi / 360));
    depths_[static_cast<std::size_t>(sun_)].begin(sun_space(view, view.sun, texel(kTexelsInHeight), size));
  }
  for (std::size_t i = 0; i < view.lights.size(); ++i) {
    if (points_[i] < 0) continue;
    DepthSpace space{};
    space.point = true;
    put_vector(view.lights[i].position, space.origin);
    space.size = view.lights[i].radius;
    depths_[static_cast<std::size_t>(points_[i])].begin(space);
  }
  sky_ = {};
  occlusion_ = view.occlusion;
  sky_depths_.resize(view.occlusion > 0 ? SkyDepths::kMaps : 0);
  sky_.reach = static_cast<float>(occlusion_reach(view));
  double x = 1, z = 0;
  for (std::size_t k = 0; k < sky_depths_.size(); ++k) {
    const double y = (static_cast<double>(k) + 0.5) / SkyDepths::kMaps, aside = std::sqrt(1 - y * y);
    const Vector toward{aside * x, y, aside * z};
    put_vector(toward, sky_.toward[k]);
    sky_depths_[k].begin(sun_space(view, toward, texel(kSkyTexelsInHeight), 0));
    const double turned = x * kGoldenCosine - z * kGoldenSine;  // by a golden angle
    z = x * kGoldenSine + z * kGoldenCosine;
    x = turned;
  }
}

void ShadowGrids::begin(const View& view) {
  spaces_.clear();
  points_.assign(view.lights.size(), -1);
  sun_ = -1;
  const Vector target = view.camera.look_at;
  const double height = height_at_target(view);
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
  depths_.resize(spaces_.size());
  begin_depths(view, height);
  left_.resize(spaces_.size());
}

void ShadowGrids::resolve_depths() {
  for (std::size_t light = 0; light < maps_.size(); ++light) maps_[light].sharp = depths_[light].view();
  for (std::size_t k = 0; k < sky_depths_.size(); ++k) {
    sky_.map[k] = sky_depths_[k].view();
    if (sky_.map[k].texels != nullptr) sky_.part = occlusion_;
  }
}

void ShadowGrids::resolve(const std::vector<std::int64_t>& sums, const std::vector<unsigned>& boxes) {
  for (std::size_t light = 0; light < spaces_.size(); ++light) {
    set_light_left(spaces_[light], sums.data() + light * numbers(), boxes[light], left_[light]);
    if (left_[light].empty()) continue;
    maps_[light].space = spaces_[light];
    maps_[light].left = left_[light].data();
  }
}

}  // namespace motes::image
