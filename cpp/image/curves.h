// Elementary functions built from + - * / sqrt only. Results of the C library differ between processors and versions,
// and pixels must not.
#pragma once

#include <cmath>

namespace motes::image {

/// Returns the tangent of x radians, 0 <= x < pi/2, to about 1e-15 relative where x is not close to pi/2.
inline double tangent(double x) {
  // Taylor series: x/2 <= 0.79, where 12 terms reach double precision; then the double angle.
  const double half = 0.5 * x;
  const double square = half * half;
  double sine = 1, cosine = 1;
  for (int i = 12; i >= 1; --i) {
    sine = 1 - square / (2.0 * i * (2.0 * i + 1)) * sine;
    cosine = 1 - square / (2.0 * i * (2.0 * i - 1)) * cosine;
  }
  sine *= half;
  return 2 * sine * cosine / ((cosine - sine) * (cosine + sine));
}

/// Returns the cube root of x >= 0.
inline double cube_root(double x) {
  if (!(x > 0)) return 0;
  double scale = 1;
  for (; x < 0.125; x *= 8) scale *= 0.5;
  for (; x > 1; x *= 0.125) scale *= 2;
  double root = 0.45 + 0.55 * x;  // within 20 % on [1/8, 1]: six Newton steps are more than enough
  for (int i = 0; i < 6; ++i) root = (2 * root + x / (root * root)) / 3;
  return root * scale;
}

/// Encodes linear 0..1 to 0..1 by the transfer curve of sRGB (IEC 61966-2-1).
inline double srgb(double linear) {
  if (linear <= 0.0031308) return linear > 0 ? 12.92 * linear : 0;
  // x^(1/2.4) = (x^(1/12))^5
  const double twelfth = cube_root(std::sqrt(std::sqrt(linear)));
  const double square = twelfth * twelfth;
  return 1.055 * (square * square * twelfth) - 0.055;
}

}  // namespace motes::image
