// Three-vectors in double precision, for values computed per camera or per pixel of the scenery.
#pragma once

#include <cmath>
#include <limits>

#include "image/scene.h"

namespace motes::image {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Three of a shape's numbers.
inline Vector vector_at(const shapes::Shape& s, int first) {
  return {s.number[first], s.number[first + 1], s.number[first + 2]};
}

inline Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(const Vector& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }
inline Vector unit(const Vector& a) { return a * (1 / length(a)); }

}  // namespace motes::image
