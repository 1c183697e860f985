#include "image/solids.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "image/vectors.h"

namespace motes::image {
namespace {

using shapes::Kind;
using shapes::Shape;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vector vector_at(const Shape& s, int first) { return {s.number[first], s.number[first + 1], s.number[first + 2]}; }

Vector towards(const Vector& normal, const Ray& ray) { return dot(normal, ray.along) > 0 ? normal * -1 : normal; }

// Distance to the plane through `point`; NaN or infinite where the ray runs along it.
double plane_distance(const Ray& ray, const Vector& point, const Vector& normal) {
  return dot(point - ray.from, normal) / dot(ray.along, normal);
}

bool intersect_plane(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const Vector normal = vector_at(s, 3);
  const double distance = plane_distance(ray, vector_at(s, 0), normal);
  if (!(distance > nearest && distance < farthest)) return false;
  hit = {distance, towards(unit(normal), ray), 0};
  return true;
}

bool intersect_disc(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const Vector center = vector_at(s, 0);
  const Vector normal = vector_at(s, 3);
  const double distance = plane_distance(ray, center, normal);
  if (!(distance > nearest && distance < farthest)) return false;
  const Vector offset = ray.from + ray.along * distance - center;
  const double square = dot(offset, offset);
  const double outer = s.number[6], inner = s.number[7];
  if (!(square <= outer * outer && square >= inner * inner)) return false;
  hit = {distance, towards(unit(normal), ray), 0};
  return true;
}

bool intersect_rectangle(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const Vector origin = vector_at(s, 0), u = vector_at(s, 3), v = vector_at(s, 6);
  const Vector normal = cross(u, v);
  const double distance = plane_distance(ray, origin, normal);
  if (!(distance > nearest && distance < farthest)) return false;
  // offset = a u + b v
  const Vector offset = ray.from + ray.along * distance - origin;
  const double area = dot(normal, normal);
  const double a = dot(cross(offset, v), normal) / area;
  const double b = dot(cross(u, offset), normal) / area;
  if (!(a >= 0 && a <= 1 && b >= 0 && b <= 1)) return false;
  hit = {distance, towards(unit(normal), ray), 0};
  return true;
}

bool intersect_sphere(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  const Vector offset = ray.from - vector_at(s, 0);
  const double radius = s.number[3];
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

// The part of the ray inside all three pairs of faces.
bool intersect_box(const Shape& s, const Ray& ray, double nearest, double farthest, Hit& hit) {
  double enter = -kInfinity, leave = kInfinity;
  int enter_axis = 0, leave_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double low = s.number[i] - ray.from[i], high = s.number[i + 3] - ray.from[i];
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

}  // namespace

Ball bounds(const Shape& s) {
  // A little more than needed: what is left out by mistake would be a hole in the picture.
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
    default: return {first, kInfinity};
  }
}

void check_solid(const std::string& argument, const Solid& solid) {
  const Kind kind = solid.shape.kind;
  if (kind != Kind::plane && kind != Kind::box && kind != Kind::sphere && kind != Kind::disc &&
      kind != Kind::rectangle) {
    throw std::invalid_argument(argument + " must be a Plane, Box, Sphere, Disc or Rectangle, got a " +
                                shapes::name(kind));
  }
  shapes::check(solid.shape);
}

bool intersect(const Shape& shape, const Ray& ray, double nearest, double farthest, Hit& hit) {
  switch (shape.kind) {
    case Kind::plane: return intersect_plane(shape, ray, nearest, farthest, hit);
    case Kind::box: return intersect_box(shape, ray, nearest, farthest, hit);
    case Kind::sphere: return intersect_sphere(shape, ray, nearest, farthest, hit);
    case Kind::disc: return intersect_disc(shape, ray, nearest, farthest, hit);
    case Kind::rectangle: return intersect_rectangle(shape, ray, nearest, farthest, hit);
    default: return false;
  }
}

}  // namespace motes::image
