#include "image/raycast/cast_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/vectors.h"
#include "image/curves.h"
#include "image/moments.h"

namespace motes::image {
namespace {

using shapes::Kind;
namespace numbers = shapes::numbers;

constexpr double kFogReach = 5;  // distance at which half of the light is fog, in distances from camera to look_at

void put(const Vector& v, float* to) {
  for (std::size_t i = 0; i < 3; ++i) to[i] = static_cast<float>(v[i]);
}

float square(float x) { return x * x; }

void put_plane(const Vector& point, const Vector& normal, float* to) {
  put(normal, to);
  to[3] = static_cast<float>(dot(point, normal));
}

// Writes a vector and a number: dot(vector, p) - number is the position of a point p along a rectangle's side, 0..1.
void put_side(const Vector& origin, const Vector& side, float* to) {
  put(side, to);
  to[3] = static_cast<float>(dot(origin, side));
}

// Write the numbers of a shape: see CastSolid.

void prepare(const numbers::plane& plane, const Vector& eye, float* to) {
  put_plane(vector_of(plane.point) - eye, unit(vector_of(plane.normal)), to);
}

void prepare(const numbers::disc& disc, const Vector& eye, float* to) {
  const Vector center = vector_of(disc.center) - eye;
  put_plane(center, unit(vector_of(disc.normal)), to);
  put(center, to + 4);
  to[7] = square(disc.radius);
  to[8] = square(disc.inner_radius);
}

void prepare(const numbers::rectangle& rectangle, const Vector& eye, float* to) {
  const Vector origin = vector_of(rectangle.origin) - eye, u = vector_of(rectangle.u), v = vector_of(rectangle.v);
  const Vector normal = cross(u, v);
  const double area = dot(normal, normal);
  put_plane(origin, unit(normal), to);
  put_side(origin, cross(v, normal) * (1 / area), to + 4);
  put_side(origin, cross(normal, u) * (1 / area), to + 8);
}

void prepare(const numbers::triangle& triangle, const Vector& eye, float* to) {
  const Vector p0 = vector_of(triangle.p0) - eye, p1 = vector_of(triangle.p1) - eye, p2 = vector_of(triangle.p2) - eye;
  put(p0, to);
  put(p1, to + 3);
  put(p2, to + 6);
  put(unit(cross(p1 - p0, p2 - p0)), to + 9);
}

void prepare(const numbers::box& box, const Vector& eye, float* to) {
  put(vector_of(box.low) - eye, to);
  put(vector_of(box.high) - eye, to + 3);
}

void prepare(const numbers::sphere& sphere, const Vector& eye, float* to) {
  const Vector center = vector_of(sphere.center) - eye;
  put(center, to);
  to[3] = square(sphere.radius);
  to[4] = static_cast<float>(dot(center, center) - double{sphere.radius} * sphere.radius);
}

void prepare(const numbers::axial& axial, const Vector& eye, float* to) {
  const Vector start = vector_of(axial.start) - eye, whole = vector_of(axial.end) - vector_of(axial.start);
  put(start, to);
  put(unit(whole), to + 3);
  to[6] = static_cast<float>(length(whole));
  to[7] = axial.radius;
  to[8] = axial.inner_radius;
  put(start + whole * 0.5, to + 9);
}

void prepare_shape(const shapes::Shape& s, const Vector& eye, float* to) {
  switch (s.kind) {
    case Kind::plane: return prepare(s.as<numbers::plane>(), eye, to);
    case Kind::disc: return prepare(s.as<numbers::disc>(), eye, to);
    case Kind::rectangle: return prepare(s.as<numbers::rectangle>(), eye, to);
    case Kind::triangle: return prepare(s.as<numbers::triangle>(), eye, to);
    case Kind::box: return prepare(s.as<numbers::box>(), eye, to);
    case Kind::sphere: return prepare(s.as<numbers::sphere>(), eye, to);
    case Kind::cylinder:
    case Kind::cone: return prepare(s.as<numbers::axial>(), eye, to);
    // Refused by check_solid().
    case Kind::point:
    case Kind::line:
    case Kind::blob:
    case Kind::united:
    case Kind::mesh: break;
  }
}

// The origin and the axes of a mesh.
struct Placement {
  Vector position{};
  std::array<Vector, 3> axis{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

  Vector into(const Vector& v) const { return {dot(v, axis[0]), dot(v, axis[1]), dot(v, axis[2])}; }
  Vector out_of(const Vector& v) const { return axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]; }
};

Placement placement_of(const shapes::Shape& s) {
  if (s.kind != Kind::mesh) return {};
  const auto [position, rotation] = s.as<numbers::mesh>().end;
  const double w = rotation[0], i = rotation[1], j = rotation[2], k = rotation[3];
  const double scale = 2 / (w * w + i * i + j * j + k * k);
  return {vector_of(position),
          {{{1 - scale * (j * j + k * k), scale * (i * j + k * w), scale * (i * k - j * w)},
            {scale * (i * j - k * w), 1 - scale * (i * i + k * k), scale * (j * k + i * w)},
            {scale * (i * k + j * w), scale * (j * k - i * w), 1 - scale * (i * i + j * j)}}}};
}

// Prepares a mesh and returns its bounding ball in the world's coordinates.
Ball prepare_mesh(const Placement& placement, const meshes::Bvh& tree, const Vector& eye, CastSolid& to) {
  to.nodes = tree.nodes.data();
  to.triangles = tree.triangles.data();
  to.turned = placement.axis != Placement{}.axis;
  put(placement.into(eye - placement.position), to.value);
  for (std::size_t i = 0; i < 3; ++i) put(placement.axis[i], to.value + 3 + 3 * i);
  return {placement.position + placement.out_of(tree.ball.center), tree.ball.radius};
}

// Makes the origin of positions relative to the eye.
void to_eye(const Vector& eye, float (&origin)[3]) {
  for (std::size_t i = 0; i < 3; ++i) {
    origin[i] = static_cast<float>(static_cast<double>(origin[i]) - eye[i]);
  }
}

// Returns the shadows of particles for positions relative to the eye.
ShadowMap seen_from(const Vector& eye, const ShadowMap* map) {
  if (map == nullptr) return {};
  ShadowMap seen = *map;
  to_eye(eye, seen.space.origin);
  to_eye(eye, seen.sharp.space.origin);
  return seen;
}

Ball ball_around(const Reach& reach) {
  Vector low{}, high{};
  for (std::size_t i = 0; i < 3; ++i) low[i] = reach.low[i], high[i] = reach.high[i];
  // Samples within a pixel may lie a little outside.
  return {(low + high) * 0.5, length(high - low) * 0.51 + 1e-6};
}

// Returns whether rays from the ball `from` to a light may touch `ball`. They are `far` metres long, and the bundle is
// wider than `from` by `wide` metres, and by `per_metre` per metre.
bool in_between(const Ball& ball, const Ball& from, const Vector& direction, double far, double wide,
                double per_metre) {
  double room = ball.radius + from.radius + wide;
  if (!(room < kInfinity)) return true;
  const Vector offset = ball.center - from.center;
  const double along = std::clamp(dot(offset, direction), 0.0, far);
  const Vector aside = offset - direction * along;
  room += per_metre * (along + room);
  return dot(aside, aside) <= room * room;
}

const LightPlaces& light_places() {
  static const LightPlaces all = [] {
    LightPlaces made{};
    for_each_moment(LightPlaces::kAll, [&](int i, const Moment& m) {
      constexpr int kInner = 48;
      const int inner = i % 6 == 0 ? 16 + i / 6 : LightPlaces::kFirst + i - i / 6 - 1;
      const int at = i >= kInner ? i - kInner : inner;
      made.x[at] = m.lens_x;
      made.y[at] = m.lens_y;
    });
    return made;
  }();
  return all;
}

}  // namespace

CastScene::CastScene(const View& view, const ShadowGrids* shadows)
    : view_(view), lens_(lens(view)), sunny_(sun_of(view).shines), sun_(sunny_ ? unit(view.sun) : Vector{0, 1, 0}),
      sun_spread_(tangent(double{view.sun_size} * (std::numbers::pi / 360))) {
  for (std::size_t i = 0; i < view.objects.size(); ++i) add(view.objects[i], static_cast<std::uint32_t>(i));
  for (const std::vector<CastSolid>* all : {&solids_, &glass_}) {
    for (const CastSolid& solid : *all) {
      Material& material = materials_[solid.number];
      if (solid.nodes == nullptr) continue;
      const bool corners = material.colors != nullptr || material.uv != nullptr || material.normals != nullptr;
      const bool pictured = material.image != nullptr || material.finish_image != nullptr;
      if (corners || pictured) material.mesh = &solid;
      cast_.colored |= corners;
    }
  }
  put(lens_.right, cast_.right);
  put(lens_.up, cast_.up);
  put(lens_.forward, cast_.forward);
  cast_.middle_x = 0.5f * static_cast<float>(view.width);
  cast_.middle_y = 0.5f * static_cast<float>(view.height);
  cast_.pixel = static_cast<float>(1 / lens_.focal_px);
  cast_.near = static_cast<float>(view.camera.near);

  shade_.cast = cast_;
  shade_.materials = materials_.data();
  shade_.sun = sun_of(view);
  shade_.places = &light_places();
  const Vector across = unit(cross(sun_, std::fabs(sun_[1]) < 0.9 ? Vector{0, 1, 0} : Vector{1, 0, 0}));
  put(across * sun_spread_, shade_.sun_right);
  put(cross(across, sun_) * sun_spread_, shade_.sun_up);
  shade_.sky = sky_lanes(view);
  shade_.ambient = ambient(view);
  shade_.bare = view.bare;
  shade_.has_images = std::any_of(materials_.begin(), materials_.end(), [](const Material& m) { return m.image; });
  shade_.reflects =
      std::any_of(materials_.begin(), materials_.end(), [](const Material& m) { return m.finish.reflects(); });
  shade_.sun_shadow = seen_from(lens_.eye, shadows == nullptr ? nullptr : shadows->of_sun());
  if (shadows != nullptr && shadows->of_sky() != nullptr) {
    shade_.sky_depths = *shadows->of_sky();
    for (DepthView& map : shade_.sky_depths.map) to_eye(lens_.eye, map.space.origin);
  }
  shade_.occlusion = view.occlusion;
  shade_.occlusion_reach = static_cast<float>(occlusion_reach(view));
  put(lens_.eye, shade_.eye);
  std::copy(view.fog.color.begin(), view.fog.color.end(), shade_.fog);
  shade_.fog_density = view.fog.metres > 0 ? 1 / view.fog.metres : 0;
  const double reach = kFogReach * length(view.camera.look_at - view.camera.position);
  shade_.fog_square = static_cast<float>(reach * reach);
  for (const double x : lens_.eye) shade_.grain = std::max(shade_.grain, static_cast<float>(std::fabs(x) * 1e-6));
  before_lights_.resize(view.lights.size());
  for (std::size_t i = 0; i < view.lights.size(); ++i) {
    const Light& light = view.lights[i];
    CastLight prepared{};
    static_cast<Lamp&>(prepared) = lamp_of(light, lens_.eye);
    prepared.shadow = seen_from(lens_.eye, shadows == nullptr ? nullptr : shadows->of_light(i));
    prepared.radius = light.radius;
    lights_.push_back(prepared);
  }
}

void CastScene::add(const Solid& solid, std::uint32_t number) {
  Material material{};
  std::copy(solid.color.begin(), solid.color.end(), material.color);
  material.emitted = solid.light;
  material.image = solid.image == 0 ? nullptr : &texture(solid.image);
  material.scale = solid.scale;
  material.finish = solid.finish;
  material.glass = solid.glass;
  material.finish_image = solid.finish_image == 0 ? nullptr : &texture(solid.finish_image);
  const bool pictured = material.image != nullptr || material.finish_image != nullptr;
  materials_.push_back(material);
  CastSolid prepared{};
  prepared.number = number;
  Ball ball{};
  if (solid.mesh != 0) {
    const auto tree = meshes::bvh_of(solid.mesh);
    if (tree->nodes.empty()) return;
    trees_.push_back(tree);
    if (!tree->colors.empty()) materials_.back().colors = tree->colors.data();
    if (!tree->uv.empty() && pictured) materials_.back().uv = tree->uv.data();
    if (!tree->normals.empty()) materials_.back().normals = tree->normals.data();
    ball = prepare_mesh(placement_of(solid.shape), *tree, lens_.eye, prepared);
  } else {
    prepared.kind = solid.shape.kind;
    prepare_shape(solid.shape, lens_.eye, prepared.value);
    ball = bounds(solid.shape);
  }
  ball.center = ball.center - lens_.eye;
  put(ball.center, prepared.center);
  prepared.radius = static_cast<float>(ball.radius);
  if (solid.glass > 0) {
    glass_.push_back(prepared);
    glass_bounds_.push_back(bounds_on_screen(ball));
    return;
  }
  solids_.push_back(prepared);
  balls_.push_back(ball);
  bounds_.push_back(bounds_on_screen(ball));
}

CastScene::Bounds CastScene::bounds_on_screen(const Ball& ball) const {
  constexpr Bounds kEverywhere{-kInfinity, kInfinity, kInfinity, -kInfinity};
  constexpr Bounds kNowhere{kInfinity, -kInfinity, -kInfinity, kInfinity};
  if (ball.radius == kInfinity) return kEverywhere;
  // Slightly too large: bounds that are too small would leave a hole in the picture.
  const double radius = ball.radius * (1 + 1e-5) + length(ball.center) * 1e-6;
  const double depth = dot(ball.center, lens_.forward);
  const double nearest = depth - radius, farthest = depth + radius;
  if (farthest <= view_.camera.near) return kNowhere;
  if (nearest <= view_.camera.near) return kEverywhere;
  // Bounds of x / z over the cube around the ball.
  const auto least = [&](double x) { return x / (x > 0 ? farthest : nearest); };
  const auto greatest = [&](double x) { return x / (x > 0 ? nearest : farthest); };
  const double x = dot(ball.center, lens_.right), y = dot(ball.center, lens_.up);
  return {least(x - radius), greatest(y + radius), greatest(x + radius), least(y - radius)};
}

const CastView& CastScene::aim(double left, double top, double right, double bottom) {
  const Bounds part{across(left), upward(top), across(right), upward(bottom)};
  const auto visible = [&](const Bounds& b) {
    return b.left <= part.right && b.right >= part.left && b.bottom <= part.top && b.top >= part.bottom;
  };
  seen_.clear();
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    if (visible(bounds_[i])) seen_.push_back(solids_[i]);
  }
  cast_.glass = std::any_of(glass_bounds_.begin(), glass_bounds_.end(), visible);
  cast_.solids = seen_.data();
  cast_.count = seen_.size();
  return cast_;
}

// Objects that emit light cast no shadow, so a light may stand inside a lamp. Glass casts none either.
const ShadeView& CastScene::light(const Reach& reach) {
  constexpr float kFar = std::numeric_limits<float>::max();
  // Through glass, any surface may be seen.
  const Ball ball = ball_around(glass_.empty() ? reach : Reach{{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}});
  const auto collect = [&](const Vector& direction, double far, double wide, double per_metre,
                           std::vector<CastSolid>& to) {
    to.clear();
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      if (materials_[solids_[i].number].emitted > 0) continue;
      if (in_between(balls_[i], ball, direction, far, wide, per_metre)) to.push_back(solids_[i]);
    }
  };
  if (sunny_) collect(sun_, kInfinity, 0, sun_spread_, before_sun_);
  shade_.cast.solids = before_sun_.data();
  shade_.cast.count = before_sun_.size();
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const Vector way = view_.lights[i].position - lens_.eye - ball.center;
    const double far = length(way);
    collect(far > 0 ? way * (1 / far) : way, far, double{view_.lights[i].radius}, 0, before_lights_[i]);
    lights_[i].solids = before_lights_[i].data();
    lights_[i].count = before_lights_[i].size();
  }
  shade_.opaque = solids_.data();
  shade_.opaque_count = solids_.size();
  shade_.glass = glass_.data();
  shade_.glass_count = glass_.size();
  if (view_.occlusion > 0) collect({}, 0, double{shade_.occlusion_reach}, 0, around_);
  shade_.around = around_.data();
  shade_.around_count = around_.size();
  shade_.lights = lights_.data();
  shade_.light_count = lights_.size();
  return shade_;
}

}  // namespace motes::image
