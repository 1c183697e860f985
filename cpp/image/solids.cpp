#include "image/solids.h"

#include <algorithm>
#include <cmath>

#include "base/invalid_argument.h"
#include "base/vectors.h"

namespace motes::image {
namespace {

using shapes::Kind;
using shapes::Shape;

}  // namespace

Ball bounds(const Shape& s) {
  // Slightly too large: a ball that is too small would leave a hole in the picture.
  constexpr double kMore = 1 + 1e-9;
  const Vector first = vector_at(s, 0);
  switch (s.kind) {
    case Kind::sphere: return {first, s.number[3] * kMore};
    case Kind::disc: return {first, s.number[6] * kMore};
    case Kind::box: return {(first + vector_at(s, 3)) * 0.5, length(vector_at(s, 3) - first) * (0.5 * kMore)};
    case Kind::rectangle: {
      const Vector u = vector_at(s, 3), v = vector_at(s, 6);
      return {first + (u + v) * 0.5, std::max(length(u + v), length(u - v)) * (0.5 * kMore)};
    }
    case Kind::triangle: {
      const Vector second = vector_at(s, 3), third = vector_at(s, 6);
      const Vector center = (first + second + third) * (1.0 / 3);
      return {center, std::max({length(first - center), length(second - center), length(third - center)}) * kMore};
    }
    case Kind::cylinder:
    case Kind::cone: {
      const Vector half = (vector_at(s, 3) - first) * 0.5;
      return {first + half, std::hypot(length(half), s.number[6]) * kMore};
    }
    // Infinite, or refused by check_solid().
    case Kind::plane:
    case Kind::point:
    case Kind::line:
    case Kind::blob:
    case Kind::united:
    case Kind::mesh: break;  // bounded by its BVH
  }
  return {first, kInfinity};
}

void check_solid(const std::string& argument, const Solid& solid) {
  const Kind kind = solid.shape.kind;
  if (!shapes::has_surface(kind) || kind == Kind::united || kind == Kind::mesh) {
    throw base::InvalidArgument(argument, "be a shape with a surface", "a " + shapes::name(kind));
  }
  shapes::check(solid.shape);
}

}  // namespace motes::image
