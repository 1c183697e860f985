#include "image/light/depth_casters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/vectors.h"
#include "image/light/particle_light.h"

namespace motes::image {

// Axes of a posed particle, of length `scale`.
struct DepthCasters::Stance {
  std::array<Vector, 3> axis;

  Vector out_of(double x, double y, double z) const { return axis[0] * x + axis[1] * y + axis[2] * z; }
};

// The corners of a triangle relative to the origin of a map, m, and for cards
// their places on the picture, 0..1.
struct DepthCasters::Triangle {
  std::array<Vector, 3> corner;
  std::array<std::array<double, 2>, 3> on_picture{};
  const ImageLevel* picture = nullptr;
};

namespace {

// One plane of a map: its axes, and the lattice of its texels in coordinates
// across the light's rays, m or tangents.
struct Plane {
  int number;
  bool point;
  std::array<Vector, 3> axis;
  double step, first[2];

  Vector into(const Vector& v) const { return {dot(v, axis[0]), dot(v, axis[1]), dot(v, axis[2])}; }
  double place_of(int axis_number, double texel) const { return (first[axis_number] + texel + 0.5) * step; }
};

Plane plane_of(const DepthSpace& space, int number) {
  Plane plane{number, space.point, {}, 0, {}};
  if (space.point) {
    const auto major = static_cast<std::size_t>(number / 2);
    plane.axis[0][(major + 1) % 3] = 1;
    plane.axis[1][(major + 2) % 3] = 1;
    plane.axis[2][major] = number % 2 == 0 ? 1 : -1;
    plane.step = 1 / double{kFaceTexels};
    plane.first[0] = plane.first[1] = -kDepthSide / 2;
    return plane;
  }
  plane.axis = {vector_of(space.right), vector_of(space.up), vector_of(space.ahead)};
  plane.step = static_cast<double>(1 << number) / double{space.texels};
  for (std::size_t i = 0; i < 2; ++i) plane.first[i] = double{space.first[number][i]};
  return plane;
}

// The planes of a map.
std::vector<Plane> planes_of(const DepthSpace& space) {
  std::vector<Plane> planes;
  for (int number = 0; number < space.planes(); ++number) planes.push_back(plane_of(space, number));
  return planes;
}

// A rectangle of texels: first and last column and row.
struct Texels {
  int columns[2], rows[2];

  bool empty() const { return columns[0] > columns[1] || rows[0] > rows[1]; }
};

// Returns the texels whose middles are within a rectangle of a plane.
Texels texels_within(const Plane& plane, const double (&low)[2], const double (&high)[2]) {
  Texels all{};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto bound = [&](double place) {
      return std::clamp(place / plane.step - plane.first[i] - 0.5, -1.0, 2048.0);
    };
    int* const to = i == 0 ? all.columns : all.rows;
    to[0] = std::max(kDepthSide + 1 - static_cast<int>(kDepthSide + 1 - bound(low[i])),
                     0); // rounded up
    to[1] = std::min(static_cast<int>(bound(high[i]) + 1) - 1,
                     kDepthSide - 1); // rounded down
  }
  return all;
}

// Returns whether no place that is looked up in a plane of the sun can have
// these texels in its filter, because that place is within the finer plane
// before it.
bool within_finer(const std::vector<Plane>& planes, const Plane& plane, const double (&low)[2],
                  const double (&high)[2]) {
  if (plane.point || plane.number == 0) return false;
  const Plane& finer = planes[static_cast<std::size_t>(plane.number) - 1];
  constexpr double kEdge = 3 * kDepthMargin + 8;
  for (std::size_t i = 0; i < 2; ++i) {
    const double from = low[i] / finer.step - finer.first[i], to = high[i] / finer.step - finer.first[i];
    if (from < kEdge || to > kDepthSide - kEdge) return false;
  }
  return true;
}

// Calls use(texels of the page, rectangle within it, first column, first row)
// for each page that a rectangle touches.
template <class Use>
void for_each_page(const Texels& all, int plane, DepthMap& map, const Use& use) {
  for (int row = all.rows[0] / kDepthPage; row <= all.rows[1] / kDepthPage; ++row) {
    for (int column = all.columns[0] / kDepthPage; column <= all.columns[1] / kDepthPage; ++column) {
      const int left = column * kDepthPage, top = row * kDepthPage;
      const Texels part{{std::max(all.columns[0] - left, 0), std::min(all.columns[1] - left, kDepthPage - 1)},
                        {std::max(all.rows[0] - top, 0), std::min(all.rows[1] - top, kDepthPage - 1)}};
      use(map.page(plane, column, row), part, left, top);
    }
  }
}

constexpr double kFaceReach = (kDepthSide / 2) / double{kFaceTexels}; // tangents

// Computes the bounds of a ball in the tangents of a lamp's face; returns
// whether it may be there.
bool bound_ball(const Vector& center, double radius, double (&low)[2], double (&high)[2]) {
  const double z = center[2], room = radius * 1.5;
  if (z + radius <= 0) return false;
  for (std::size_t i = 0; i < 2; ++i) {
    const double x = center[i];
    if (std::fabs(x) > kFaceReach * z + room) return false;
    low[i] = -kFaceReach;
    high[i] = kFaceReach;
    if (z <= radius * 1.001) continue;
    const double square = z * z - radius * radius, root = radius * std::sqrt(x * x + square);
    low[i] = (x * z - root) / square;
    high[i] = (x * z + root) / square;
  }
  return true;
}

void draw_ball(const Vector& place, double radius, const std::vector<Plane>& planes, DepthMap& map,
               const LightLanes& lanes) {
  const bool point = map.space().point;
  if (point && dot(place, place) <= radius * radius) return;
  for (const Plane& plane : planes) {
    const Vector center = plane.into(place);
    double low[2], high[2];
    if (point) {
      if (!bound_ball(center, radius, low, high)) continue;
    } else {
      for (std::size_t i = 0; i < 2; ++i) low[i] = center[i] - radius, high[i] = center[i] + radius;
    }
    if (within_finer(planes, plane, low, high)) break;
    const Texels all = texels_within(plane, low, high);
    if (all.empty()) continue;
    DepthBall ball{};
    ball.point = point;
    for (std::size_t i = 0; i < 3; ++i) ball.center[i] = static_cast<float>(center[i]);
    ball.square = static_cast<float>(radius * radius);
    ball.step = static_cast<float>(plane.step);
    for_each_page(all, plane.number, map, [&](float* texels, const Texels& part, int left, int top) {
      ball.left = static_cast<float>(plane.place_of(0, left));
      ball.top = static_cast<float>(plane.place_of(1, top));
      std::copy_n(part.columns, 2, ball.columns);
      std::copy_n(part.rows, 2, ball.rows);
      lanes.keep_ball(ball, texels);
    });
  }
}

// A linear function of the coordinates across the light's rays.
struct Linear {
  double x, y, rest;

  double at(double to_x, double to_y) const { return x * to_x + y * to_y + rest; }
};

// Returns functions that are the parts of a triangle's corners 2, 0 and 1 at a
// place, times a common factor, and at least 0 within it; for a lamp their sum
// is `all` / depth.
std::array<Linear, 3> parts_of(const Plane& plane, const std::array<Vector, 3>& p, double& all) {
  std::array<Linear, 3> part{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector &a = p[k], &b = p[(k + 1) % 3];
    if (plane.point) {
      const Vector n = cross(a, b);
      part[k] = {n[0], n[1], n[2]};
    } else {
      part[k] = {a[1] - b[1], b[0] - a[0], (b[1] - a[1]) * a[0] - (b[0] - a[0]) * a[1]};
    }
  }
  all = plane.point ? dot(p[0], cross(p[1], p[2]))
                    : (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
  if (all < 0) {
    all = -all;
    for (Linear& one : part) one = {-one.x, -one.y, -one.rest};
  }
  return part;
}

bool is_opaque(const ImageLevel& picture, double across, double down) {
  const auto texel = [](double part, int count) { return std::clamp(static_cast<int>(part * count), 0, count - 1); };
  const int column = texel(across, picture.width), row = texel(down, picture.height);
  return picture.texels[4 * ((row + 1) * (picture.width + 2) + column + 1) + 3] >= 16384;
}

// Returns the bounds of a triangle in a plane; false if it is behind the lamp.
bool bound_triangle(const Plane& plane, const std::array<Vector, 3>& p, double (&low)[2], double (&high)[2]) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double nearest = std::min({p[0][2], p[1][2], p[2][2]}), farthest = std::max({p[0][2], p[1][2], p[2][2]});
  if (plane.point && farthest <= 0) return false;
  for (std::size_t i = 0; i < 2; ++i) {
    low[i] = kInfinity;
    high[i] = -kInfinity;
    for (const Vector& corner : p) {
      const double place = plane.point ? corner[i] / std::max(corner[2], 1e-9) : corner[i];
      low[i] = std::min(low[i], place);
      high[i] = std::max(high[i], place);
    }
    if (plane.point && nearest <= 1e-6) low[i] = -kFaceReach, high[i] = kFaceReach;
  }
  return true;
}

template <class Triangle>
void draw_triangle(const Triangle& t, const std::vector<Plane>& planes, DepthMap& map) {
  for (const Plane& plane : planes) {
    const std::array<Vector, 3> p{plane.into(t.corner[0]), plane.into(t.corner[1]), plane.into(t.corner[2])};
    double low[2], high[2], scale = 0;
    if (!bound_triangle(plane, p, low, high)) continue;
    if (within_finer(planes, plane, low, high)) break;
    const Texels texels = texels_within(plane, low, high);
    if (texels.empty()) continue;
    const std::array<Linear, 3> part = parts_of(plane, p, scale);
    if (!(scale > 0)) continue;
    for_each_page(texels, plane.number, map, [&](float* to, const Texels& here, int left, int top) {
      for (int row = here.rows[0]; row <= here.rows[1]; ++row) {
        const double y = plane.place_of(1, top + row);
        for (int column = here.columns[0]; column <= here.columns[1]; ++column) {
          const double x = plane.place_of(0, left + column);
          const double own[3] = {part[0].at(x, y), part[1].at(x, y), part[2].at(x, y)};
          if (own[0] < 0 || own[1] < 0 || own[2] < 0) continue;
          const double sum = own[0] + own[1] + own[2];
          if (!(sum > 0)) continue;
          const auto mean = [&](double a, double b, double c) { return (own[1] * a + own[2] * b + own[0] * c) / sum; };
          if (t.picture != nullptr &&
              !is_opaque(*t.picture, mean(t.on_picture[0][0], t.on_picture[1][0], t.on_picture[2][0]),
                         mean(t.on_picture[0][1], t.on_picture[1][1], t.on_picture[2][1])))
            continue;
          const double depth = plane.point ? scale / sum : mean(p[0][2], p[1][2], p[2][2]);
          float& kept = to[row * kDepthPage + column];
          kept = std::max(kept, static_cast<float>(-depth));
        }
      }
    });
  }
}

double number_or(const float* plane, std::size_t i, float of_all) {
  return double{plane != nullptr ? plane[i] : of_all};
}

} // namespace

DepthCasters::DepthCasters(const Sprite& sprite, const View& view, const Drawn& particles)
    : sprite_(&sprite), particles_(&particles), width_(particle_width(sprite, view)), lanes_(&light_lanes()) {
  if (sprite.is(Sprite::Kind::mesh)) mesh_ = &mesh_corners(sprite.asset());
  const auto* card = sprite.as<CardSprite>();
  if (card != nullptr && card->facing != Facing::camera)
    picture_ = &image_levels(card->sheet.picture, card->sheet.tiles);
}

double DepthCasters::width_of(std::size_t i, const Vector& place) const {
  if (width_.own) return number_or(particles_->size, i, particles_->size_of_all);
  return length(place - vector_of(width_.eye)) * double{width_.per_metre};
}

DepthCasters::Stance DepthCasters::stance_of(std::size_t i, double scale) const {
  const Drawn& d = *particles_;
  if (along_velocity(*sprite_)) {
    Vector front{}, up{};
    for (std::size_t c = 0; c < 3; ++c) {
      front[c] = number_or(d.velocity[c], i, d.velocity_of_all[c]);
      up[c] = number_or(d.up[c], i, d.up_of_all[c]);
    }
    const double speed = length(front);
    front = speed > 1e-15 ? front * (1 / speed) : Vector{0, 0, 1};
    Vector right = cross(up, front);
    if (!(length(right) > 1e-6)) right = cross(std::fabs(front[1]) < 0.9 ? Vector{0, 1, 0} : Vector{1, 0, 0}, front);
    right = unit(right);
    return {{right * scale, cross(front, right) * scale, front * scale}};
  }
  double q[4], square = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    q[c] = number_or(d.orientation[c], i, d.orientation_of_all[c]);
    square += q[c] * q[c];
  }
  if (!(square > 0)) return {{Vector{scale, 0, 0}, Vector{0, scale, 0}, Vector{0, 0, scale}}};
  const double part = 1 / std::sqrt(square), x = q[0] * part, y = q[1] * part, z = q[2] * part, w = q[3] * part;
  return {{Vector{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)} * scale,
           Vector{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)} * scale,
           Vector{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)} * scale}};
}

template <class Planes>
void DepthCasters::draw_mesh(const Vector& place, const Stance& stance, const Planes& planes, DepthMap& map) const {
  const auto room = static_cast<std::size_t>(mesh_->room);
  for (std::size_t t = 0; t < static_cast<std::size_t>(mesh_->triangles); ++t) {
    Triangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      const float* const from = mesh_->planes.data() + 3 * k * room + t;
      triangle.corner[k] = place + stance.out_of(double{from[0]}, double{from[room]}, double{from[2 * room]});
    }
    draw_triangle(triangle, planes, map);
  }
}

template <class Planes>
void DepthCasters::draw_card(std::size_t i, const Vector& place, const Stance& stance, const Planes& planes,
                             DepthMap& map) const {
  const auto count = static_cast<double>(sprite_->sheet()->tiles.count);
  const double picked = particles_->tile == nullptr ? 0 : std::floor(double{particles_->tile[i]});
  const double tile = count > 1 && std::isfinite(picked) ? picked - count * std::floor(picked / count) : 0;
  const ImageLevel& level =
      picture_->levels()[static_cast<std::size_t>(tile) * static_cast<std::size_t>(picture_->number())];
  const double longer = std::max(level.width, level.height), half_x = 0.5 * level.width / longer,
               half_y = 0.5 * level.height / longer;
  for (const double side : {-1.0, 1.0}) {
    Triangle triangle;
    triangle.picture = &level;
    const std::array<std::array<double, 2>, 3> corners{{{-1, 1}, {1, -1}, {side, side}}};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [x, y] = corners[k];
      triangle.corner[k] = place + stance.out_of(x * half_x, y * half_y, 0);
      triangle.on_picture[k] = {0.5 + 0.5 * x, 0.5 - 0.5 * y};
    }
    draw_triangle(triangle, planes, map);
  }
}

void DepthCasters::draw(std::size_t first, std::size_t last, std::vector<DepthMap>& maps) const {
  const Drawn& d = *particles_;
  const bool ball = mesh_ == nullptr && picture_ == nullptr;
  for (DepthMap& map : maps) {
    const std::vector<Plane> planes = planes_of(map.space());
    for (std::size_t i = first; i < last; ++i) {
      const Vector place{double{d.position[0][i]}, double{d.position[1][i]}, double{d.position[2][i]}};
      const double width = width_of(i, place);
      const bool counts = std::isfinite(place[0]) && std::isfinite(place[1]) && std::isfinite(place[2]) && width > 0 &&
                          std::isfinite(width) && number_or(d.alpha, i, d.alpha_of_all) > 0;
      if (!counts) continue;
      const Vector from = place - vector_of(map.space().origin);
      if (ball) {
        draw_ball(from, 0.5 * width, planes, map, *lanes_);
      } else if (mesh_ != nullptr) {
        draw_mesh(from, stance_of(i, width), planes, map);
      } else {
        draw_card(i, from, stance_of(i, width), planes, map);
      }
    }
  }
}

} // namespace motes::image
