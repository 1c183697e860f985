// Three-vectors in double precision, in namespace motes so that all of the core finds their operators.
#pragma once

#include <array>
#include <cmath>
#include <limits>

namespace motes {

using Vector = std::array<double, 3>;  // metres; right-handed, y up

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A ball around an object; around a plane, its radius is infinite.
struct Ball {
  Vector center;
  double radius;
};

inline Vector vector_of(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
inline Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(const Vector& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }
inline Vector unit(const Vector& a) { return a * (1 / length(a)); }

}  // namespace motes
