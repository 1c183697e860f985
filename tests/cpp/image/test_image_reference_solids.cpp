#include "image/test_image_reference_solids.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/vectors.h"

namespace motes::image_test {
namespace {

using namespace image;
using shapes::Kind;
using shapes::Shape;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vector towards(const Vector& normal, const Ray& ray) { return dot(normal, ray.along) > 0 ? normal * -1 : normal; }

// Returns the distance to the plane through `point`; NaN or infinite if the ray is parallel to it.
double plane_distance(const Ray& ray, const Vector& point, const Vector& normal) {
  return dot(point - ray.from, normal) / dot(ray.along, normal);
}

bool intersect_plane(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const auto plane = s.as<shapes::numbers::plane>();
  const Vector normal = vector_of(plane.normal);
  const double distance = plane_distance(ray, vector_of(plane.point), normal);
  if (!(distance > nearest && distance < farthest)) return false;
  hit = {distance, towards(unit(normal), ray), 0};
  return true;
}

bool intersect_disc(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const auto disc = s.as<shapes::numbers::disc>();
  const Vector center = vector_of(disc.center), normal = vector_of(disc.normal);
  const double distance = plane_distance(ray, center, normal);
  if (!(distance > nearest && distance < farthest)) return false;
  const Vector offset = ray.from + ray.along * distance - center;
  const double square = dot(offset, offset);
  const double outer = disc.radius, inner = disc.inner_radius;
  if (!(square <= outer * outer && square >= inner * inner)) return false;
  hit = {distance, towards(unit(normal), ray), 0};
  return true;
}

// Solves offset = a u + b v, in the plane spanned by u and v.
struct Parts {
  double a, b;
};
Parts parts_of(const Vector& offset, const Vector& u, const Vector& v, const Vector& normal) {
  const double area = dot(normal, normal);
  return {dot(cross(offset, v), normal) / area, dot(cross(u, offset), normal) / area};
}

bool intersect_rectangle(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const auto rectangle = s.as<shapes::numbers::rectangle>();
  const Vector origin = vector_of(rectangle.origin), u = vector_of(rectangle.u), v = vector_of(rectangle.v);
  const Vector normal = cross(u, v);
  const double distance = plane_distance(ray, origin, normal);
  if (!(distance > nearest && distance < farthest)) return false;
  const auto [a, b] = parts_of(ray.from + ray.along * distance - origin, u, v, normal);
  if (!(a >= 0 && a <= 1 && b >= 0 && b <= 1)) return false;
  hit = {distance, towards(unit(normal), ray), 0};
  return true;
}

bool intersect_triangle(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const auto triangle = s.as<shapes::numbers::triangle>();
  const Vector origin = vector_of(triangle.p0), u = vector_of(triangle.p1) - origin,
               v = vector_of(triangle.p2) - origin;
  const Vector normal = cross(u, v);
  const double distance = plane_distance(ray, origin, normal);
  if (!(distance > nearest && distance < farthest)) return false;
  const auto [a, b] = parts_of(ray.from + ray.along * distance - origin, u, v, normal);
  constexpr double kSeam = 1e-9;  // triangles that share an edge leave no gap between them
  if (!(a >= -kSeam && b >= -kSeam && a + b <= 1 + kSeam)) return false;
  hit = {distance, towards(unit(normal), ray), 0};
  return true;
}

bool intersect_sphere(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const auto sphere = s.as<shapes::numbers::sphere>();
  const Vector offset = ray.from - vector_of(sphere.center);
  const double radius = sphere.radius;
  const double a = dot(ray.along, ray.along);
  const double b = dot(offset, ray.along);
  const double discriminant = b * b - a * (dot(offset, offset) - radius * radius);
  if (!(discriminant >= 0)) return false;
  const double root = std::sqrt(discriminant);
  double distance = (-b - root) / a;
  if (!(distance > nearest)) distance = (-b + root) / a;
  if (!(distance > nearest && distance < farthest)) return false;
  hit = {distance, towards(unit(offset + ray.along * distance), ray), 0};
  return true;
}

// Intersects the parts of the ray that are inside each of the three pairs of faces.
bool intersect_box(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const auto box = s.as<shapes::numbers::box>();
  double enter = -kInfinity, leave = kInfinity;
  int enter_axis = 0, leave_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double low = box.low[i] - ray.from[i], high = box.high[i] - ray.from[i];
    if (ray.along[i] == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const double inverse = 1 / ray.along[i];
    const double first = ray.along[i] > 0 ? low * inverse : high * inverse;
    const double last = ray.along[i] > 0 ? high * inverse : low * inverse;
    if (first > enter) enter = first, enter_axis = axis;
    if (last < leave) leave = last, leave_axis = axis;
  }
  if (!(enter <= leave)) return false;
  const bool outside = enter > nearest;
  const double distance = outside ? enter : leave;
  if (!(distance > nearest && distance < farthest)) return false;
  const int axis = outside ? enter_axis : leave_axis;
  Vector normal{};
  normal[static_cast<std::size_t>(axis)] = ray.along[static_cast<std::size_t>(axis)] > 0 ? -1 : 1;
  hit = {distance, normal, 1 + axis};
  return true;
}

// A ray in the coordinates of a cylinder or cone: at distance t, its height along the axis is height + t rise, and its
// offset from the axis is across + t aside.
struct AlongAxis {
  Vector axis;  // unit
  double length, height, rise;
  Vector across, aside;

  AlongAxis(const Shape& s, const Ray& ray) {
    const auto axial = s.as<shapes::numbers::axial>();
    const Vector start = vector_of(axial.start), whole = vector_of(axial.end) - start, from = ray.from - start;
    length = motes::length(whole);
    axis = whole * (1 / length);
    height = dot(from, axis), rise = dot(ray.along, axis);
    across = from - axis * height, aside = ray.along - axis * rise;
  }
};

// Intersects the surface whose distance from the axis is radius + widening * height, between the ends.
bool intersect_side(const AlongAxis& at, const Ray& ray, double radius, double widening, double nearest,
                    double farthest, Hit& hit) {
  const double here = radius + widening * at.height, change = widening * at.rise;
  const double a = dot(at.aside, at.aside) - change * change;
  const double b = dot(at.across, at.aside) - here * change;
  const double c = dot(at.across, at.across) - here * here;
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0)) return false;
  // Both roots without cancellation; along a cone's side a is 0 and one of them is infinite.
  const double q = b < 0 ? -b + std::sqrt(discriminant) : -b - std::sqrt(discriminant);
  const double first = std::min(q / a, c / q), second = std::max(q / a, c / q);
  for (const double distance : {first, second}) {
    const double height = at.height + distance * at.rise;
    if (!(distance > nearest && distance < farthest && height >= 0 && height <= at.length)) continue;
    const Vector outward = at.across + at.aside * distance - at.axis * (widening * (radius + widening * height));
    if (dot(outward, outward) == 0) continue;  // exactly at a cone's tip
    hit = {distance, towards(unit(outward), ray), 0};
    return true;
  }
  return false;
}

// Intersects the flat end at a height, a ring.
bool intersect_end(const AlongAxis& at, const Ray& ray, double height, double inner, double outer, double nearest,
                   double farthest, Hit& hit) {
  const double distance = (height - at.height) / at.rise;
  if (!(distance > nearest && distance < farthest)) return false;
  const Vector offset = at.across + at.aside * distance;
  const double square = dot(offset, offset);
  if (!(square <= outer * outer && square >= inner * inner)) return false;
  hit = {distance, towards(at.axis, ray), 1};
  return true;
}

// Intersects the outer wall and, for a pipe, the inner wall, with flat ends between them; with equal radii only the
// wall.
bool intersect_shell(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const AlongAxis at(s, ray);
  const bool cone = s.kind == Kind::cone;
  const auto axial = s.as<shapes::numbers::axial>();
  const double outer = axial.radius, inner = axial.inner_radius;
  const auto side = [&](double radius, int face) {
    const double reach = hit.distance;
    const bool met = cone ? intersect_side(at, ray, 0, radius / at.length, nearest, reach, hit)
                          : intersect_side(at, ray, radius, 0, nearest, reach, hit);
    if (met) hit.face = face;
    return met;
  };
  hit.distance = farthest;
  bool met = side(outer, 0);
  if (inner == outer) return met;
  if (inner > 0) met |= side(inner, 3);
  met |= intersect_end(at, ray, at.length, inner, outer, nearest, hit.distance, hit);
  if (!cone && intersect_end(at, ray, 0, inner, outer, nearest, hit.distance, hit)) {
    hit.face = 2;
    met = true;
  }
  return met;
}

}  // namespace

bool intersect(const Shape& shape, const Ray& ray, double nearest, double farthest, Hit& hit) {
  switch (shape.kind) {
    case Kind::plane: return intersect_plane(shape, ray, nearest, farthest, hit);
    case Kind::box: return intersect_box(shape, ray, nearest, farthest, hit);
    case Kind::sphere: return intersect_sphere(shape, ray, nearest, farthest, hit);
    case Kind::disc: return intersect_disc(shape, ray, nearest, farthest, hit);
    case Kind::rectangle: return intersect_rectangle(shape, ray, nearest, farthest, hit);
    case Kind::triangle: return intersect_triangle(shape, ray, nearest, farthest, hit);
    case Kind::cylinder:
    case Kind::cone: return intersect_shell(shape, ray, nearest, farthest, hit);
    // Refused by check_solid().
    case Kind::point:
    case Kind::line:
    case Kind::blob:
    case Kind::united:
    case Kind::mesh: break;
  }
  return false;
}

}  // namespace motes::image_test
