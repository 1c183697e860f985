#include "image/solids.h"

#include <algorithm>
#include <cmath>

#include "base/invalid_argument.h"
#include "base/vectors.h"

namespace motes::image {
namespace {

using shapes::Kind;
using shapes::Shape;
namespace numbers = shapes::numbers;

// Slightly too large: a ball that is too small would leave a hole in the picture.
constexpr double kMore = 1 + 1e-9;

Ball bounds(const numbers::sphere& sphere) { return {vector_of(sphere.center), sphere.radius * kMore}; }

Ball bounds(const numbers::disc& disc) { return {vector_of(disc.center), disc.radius * kMore}; }

Ball bounds(const numbers::box& box) {
  const Vector low = vector_of(box.low), high = vector_of(box.high);
  return {(low + high) * 0.5, length(high - low) * (0.5 * kMore)};
}

Ball bounds(const numbers::rectangle& rectangle) {
  const Vector u = vector_of(rectangle.u), v = vector_of(rectangle.v);
  return {vector_of(rectangle.origin) + (u + v) * 0.5, std::max(length(u + v), length(u - v)) * (0.5 * kMore)};
}

Ball bounds(const numbers::triangle& triangle) {
  const Vector p0 = vector_of(triangle.p0), p1 = vector_of(triangle.p1), p2 = vector_of(triangle.p2);
  const Vector center = (p0 + p1 + p2) * (1.0 / 3);
  return {center, std::max({length(p0 - center), length(p1 - center), length(p2 - center)}) * kMore};
}

Ball bounds(const numbers::axial& axial) {
  const Vector start = vector_of(axial.start), half = (vector_of(axial.end) - start) * 0.5;
  return {start + half, std::hypot(length(half), axial.radius) * kMore};
}

}  // namespace

Ball bounds(const Shape& s) {
  switch (s.kind) {
    case Kind::sphere: return bounds(s.as<numbers::sphere>());
    case Kind::disc: return bounds(s.as<numbers::disc>());
    case Kind::box: return bounds(s.as<numbers::box>());
    case Kind::rectangle: return bounds(s.as<numbers::rectangle>());
    case Kind::triangle: return bounds(s.as<numbers::triangle>());
    case Kind::cylinder:
    case Kind::cone: return bounds(s.as<numbers::axial>());
    // Infinite, or refused by check_solid().
    case Kind::plane:
    case Kind::point:
    case Kind::line:
    case Kind::blob:
    case Kind::united:
    case Kind::mesh: break;  // bounded by its BVH
  }
  return {vector_of(s.as<numbers::point>().position), kInfinity};
}

void check_solid(const std::string& argument, const Solid& solid) {
  const Kind kind = solid.shape.kind;
  if (!shapes::has_surface(kind) || kind == Kind::united || kind == Kind::mesh) {
    throw base::InvalidArgument(argument, "be a shape with a surface", "a " + shapes::name(kind));
  }
  shapes::check(solid.shape);
}

}  // namespace motes::image
