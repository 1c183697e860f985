// Elementary functions of lanes, built from + - * / and sqrt only: results of the C library differ between processors.
//
// Errors are in ulp, the distance between neighbouring floats at the exact result, as tests/cpp measures them.
#pragma once

#include "simd/doubles.h"

namespace motes::MOTES_ISA {

// Return sin and cos of r within +- pi / 4, by minimax polynomials (coefficients as in the Cephes library, S. Moshier).
MOTES_INLINE Floats small_sin(Floats r, Floats rr) {
  return r + r * rr * (-1.6666654611e-1f + rr * (8.3321608736e-3f + rr * -1.9515295891e-4f));
}
MOTES_INLINE Floats small_cos(Floats rr) {
  return 1.0f - 0.5f * rr +
         rr * rr * (4.166664568298827e-2f + rr * (-1.388731625493765e-3f + rr * 2.443315711809948e-5f));
}

/// Computes cos and sin of `turn` whole turns, for turn in [0, 1]. Error below 1e-7.
MOTES_INLINE void cos_sin_turn(Floats turn, Floats& cosine, Floats& sine) {
  const Floats quarters = turn * 4.0f;
  const Ints nearest = to_ints(quarters + 0.5f);
  const Floats r = (quarters - to_floats(nearest)) * 1.57079632679f;  // within +- pi / 4
  const Floats rr = r * r;
  const Floats s = small_sin(r, rr);
  const Floats c = small_cos(rr);
  const Mask odd = (nearest & 1) != 0;
  const Floats x = select(odd, s, c);
  const Floats y = select(odd, c, s);
  cosine = select(((nearest + 1) & 2) != 0, -x, x);
  sine = select((nearest & 2) != 0, -y, y);
}

// Returns x minus the nearest multiple of pi / 2. `quarter`: which multiple it is, modulo 4: -2..2.
MOTES_INLINE Doubles from_quarter(Doubles x, Doubles& quarter) {
  constexpr double kFirst33 = 1.57079632673412561417e+00;  // pi / 2 = kFirst33 + kRest, 33 bits of it: products with
  constexpr double kRest = 6.07710050650619224932e-11;     // whole numbers below 2^20 are exact
  const Doubles k = round(x * 0.636619772367581343);
  quarter = k - 4.0 * round(k * 0.25);
  return (x - k * kFirst33) - k * kRest;
}

/// Computes cos and sin of x radians: 2 ulp for |x| <= 1e6. Beyond that the absolute error stays below 3e-7 up to 1e9;
/// larger numbers count as 0. NaN for infinities.
MOTES_INLINE void cos_sin(Floats x, Floats& cosine, Floats& sine) {
  const Floats known = select(abs(x) <= 1e9f, x, Floats{});
  Doubles low_quarter, high_quarter;
  const Doubles low = from_quarter(low_half(known), low_quarter);
  const Doubles high = from_quarter(high_half(known), high_quarter);
  const Floats r = join(low, high);
  const Ints quarter = to_ints(join(low_quarter, high_quarter));
  const Floats rr = r * r;
  const Floats s = small_sin(r, rr);
  const Floats c = small_cos(rr);
  const Mask odd = (quarter & 1) != 0;
  // NaN where x is not finite, else 0.
  const Floats strange = x - x;  // NOLINT(misc-redundant-expression)
  const Floats across = select(odd, s, c), up = select(odd, c, s);
  cosine = select(((quarter + 1) & 2) != 0, -across, across) + strange;
  sine = select((quarter & 2) != 0, -up, up) + strange;
}

MOTES_INLINE Floats sin(Floats x) {
  Floats cosine, sine;
  cos_sin(x, cosine, sine);
  return sine;
}

MOTES_INLINE Floats cos(Floats x) {
  Floats cosine, sine;
  cos_sin(x, cosine, sine);
  return cosine;
}

/// Returns the natural logarithm of normal positive numbers. Error below 2e-7 relative to max(1, |log|).
MOTES_INLINE Floats log(Floats v) {
  const Ints bits = (Ints)v;
  Ints exponent = (bits >> 23) - 126;
  Floats m = (Floats)((bits & 0x007fffff) | 0x3f000000);  // in [0.5, 1)
  const Mask low = m < 0.70710678f;
  exponent += low;  // a true mask is -1
  m = select(low, m + m, m) - 1.0f;
  const Floats mm = m * m;
  Floats p = all(7.0376836292e-2f);
  p = p * m - 1.1514610310e-1f;
  p = p * m + 1.1676998740e-1f;
  p = p * m - 1.2420140846e-1f;
  p = p * m + 1.4249322787e-1f;
  p = p * m - 1.6668057665e-1f;
  p = p * m + 2.0000714765e-1f;
  p = p * m - 2.4999993993e-1f;
  p = p * m + 3.3333331174e-1f;
  const Floats e = to_floats(exponent);
  return (m + (m * mm * p + e * -2.12194440e-4f - 0.5f * mm)) + e * 0.693359375f;
}

/// Returns the cube root of numbers >= 0. Error below 2e-7 relative.
MOTES_INLINE Floats cube_root(Floats v) {
  const Floats third = to_floats((Ints)v) * (1.0f / 3.0f);
  Floats y = (Floats)(to_ints(third) + 0x2a514067);  // a third of the exponent: within 6 %
  for (int i = 0; i < 3; ++i) y = y - (y * y * y - v) / (3.0f * y * y);
  return select(v > 0.0f, y, Floats{});
}

// Returns e^r 2^n for r within +- ln(2) / 2 and n in -152..129. The power of two is applied as two factors: neither
// overflows, and a result below the normal numbers is rounded only once.
MOTES_INLINE Floats scaled_exp(Floats r, Ints n) {
  Floats p = all(1.9875691500e-4f);  // coefficients as in the Cephes library
  p = p * r + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  const Floats e = (p * r * r + r) + 1.0f;
  const Ints half = n >> 1;
  return e * (Floats)((half + 127) << 23) * (Floats)((n - half + 127) << 23);
}

MOTES_INLINE Ints nearest(Floats v) { return to_ints(v + select(v < 0.0f, all(-0.5f), all(0.5f))); }

/// Returns e^x: 2 ulp, denormal results included; infinite above 88.73, 0 below -103.98.
MOTES_INLINE Floats exp(Floats x) {
  const Floats known = max(min(x, all(89.0f)), all(-105.0f));
  const Ints n = nearest(known * 1.44269504089f);
  const Floats k = to_floats(n);
  // ln(2) in two parts: the first has so few bits that its product with k is exact.
  const Floats r = (known - k * 0.693359375f) - k * -2.12194440e-4f;
  return select(x == x, scaled_exp(r, n), x);
}

/// Returns 2^x: 2 ulp, denormal results included; infinite from 128, 0 below -150.
MOTES_INLINE Floats exp2(Floats x) {
  const Floats known = max(min(x, all(129.0f)), all(-151.0f));
  const Ints n = nearest(known);
  const Floats r = (known - to_floats(n)) * 0.69314718056f;
  return select(x == x, scaled_exp(r, n), x);
}

// Returns the base-2 logarithm of x >= 0, to 40 bits; a float's denormal numbers are normal here.
MOTES_INLINE Doubles log2_half(Doubles x) {
  const Longs bits = (Longs)x;
  const Longs one = (Longs)all_doubles(1.0);
  Doubles m = (Doubles)((bits & 0x000fffffffffffff) | one);  // in [1, 2)
  // The exponent, written into the low bits of 2^52, becomes a number without a conversion instruction.
  Doubles exponent = (Doubles)((bits >> 52) | (Longs)all_doubles(0x1p52)) - (0x1p52 + 1023.0);
  const Longs large = m > 1.4142135623730951;
  m = select(large, m * 0.5, m);
  exponent = select(large, exponent + 1.0, exponent);
  // log(m) = 2 artanh(s): a series in s^2 <= 0.0295
  const Doubles s = (m - 1.0) / (m + 1.0);
  const Doubles ss = s * s;
  Doubles p = ss * (1.0 / 13) + 1.0 / 11;
  p = p * ss + 1.0 / 9;
  p = p * ss + 1.0 / 7;
  p = p * ss + 1.0 / 5;
  p = p * ss + 1.0 / 3;
  const Doubles log2_m = (s + s * ss * p) * 2.8853900817779268;
  const Doubles finite = exponent + log2_m;
  const Doubles infinity = all_doubles(__builtin_inf());
  return select(x == 0.0, -infinity, select(x == infinity, infinity, finite));
}

// Returns 2^t, with t clamped to the range of floats.
MOTES_INLINE Doubles exp2_half(Doubles t) {
  t = select(t < 200.0, t, all_doubles(200.0));
  t = select(t > -200.0, t, all_doubles(-200.0));
  const Doubles shifted = t + kWhole;  // the low bits hold the nearest integer
  const Doubles f = (t - (shifted - kWhole)) * 0.69314718055994531;
  Doubles p = f * (1.0 / 40320) + 1.0 / 5040;
  p = p * f + 1.0 / 720;
  p = p * f + 1.0 / 120;
  p = p * f + 1.0 / 24;
  p = p * f + 1.0 / 6;
  p = p * f + 0.5;
  p = p * f + 1.0;
  p = p * f + 1.0;
  return p * (Doubles)(((Longs)shifted << 52) + (Longs)all_doubles(1.0));
}

/// Returns x^y for x >= 0, by the C library's rules: x^0 = 1^y = 1, 0^y = 0 or infinite; NaN for x < 0. 1 ulp.
MOTES_INLINE Floats pow(Floats x, Floats y) {
  const Floats magnitude = abs(x);
  const Doubles low = exp2_half(low_half(y) * log2_half(low_half(magnitude)));
  const Doubles high = exp2_half(high_half(y) * log2_half(high_half(magnitude)));
  const Floats power = join(low, high);
  const Mask unclear = ~(x >= 0.0f) | (y != y);
  return select((x == 1.0f) | (y == 0.0f), all(1.0f), select(unclear, all(__builtin_nanf("")), power));
}

// Returns the angle of the direction (x, y). Signs are taken from the sign bits, so -0 counts as negative.
MOTES_INLINE Doubles angle_half(Doubles y, Doubles x) {
  constexpr double kPi = 3.14159265358979323846;
  const Doubles a = abs(y), b = abs(x);
  const Longs upright = a > b;
  const Doubles large = select(upright, a, b);
  const Doubles small = select(upright, b, a);
  const Longs diagonal = (small > large * 0.41421356237309503) | (small == __builtin_inf());  // above tan(pi / 8)
  Doubles above = select(diagonal, small - large, small);
  const Doubles below = select(diagonal, small + large, large);
  above = select(small == __builtin_inf(), Doubles{}, above);  // both infinite: the diagonal
  const Doubles t = above / select(large == 0.0, all_doubles(1.0), below);
  const Doubles z = t * t;
  Doubles p = z * -0.0404303386674414 + 0.07135234752100453;
  p = p * z - 0.0902896758587614;
  p = p * z + 0.11107493855916296;
  p = p * z - 0.1428561246539342;
  p = p * z + 0.1999999891669261;
  p = p * z - 0.3333333333143951;
  Doubles angle = t + t * z * p;
  angle = select(diagonal, angle + kPi / 4, angle);
  angle = select(upright, kPi / 2 - angle, angle);
  angle = select((Longs)x < 0, kPi - angle, angle);
  const Longs sign = (Longs)y & (Longs)all_doubles(-0.0);
  return select((x == x) & (y == y), (Doubles)((Longs)angle ^ sign), x + y);
}

/// Returns the angle in -pi..pi from the x axis to (x, y), by the C library's rules. 1 ulp.
MOTES_INLINE Floats atan2(Floats y, Floats x) {
  return join(angle_half(low_half(y), low_half(x)), angle_half(high_half(y), high_half(x)));
}

// Returns the other leg of a right triangle with hypotenuse 1; NaN if |side| > 1.
MOTES_INLINE Doubles other_side(Doubles side) { return sqrt((1.0 - side) * (1.0 + side)); }

/// Returns the arcsine: 1 ulp; NaN if |v| > 1.
MOTES_INLINE Floats asin(Floats v) {
  const Doubles low = low_half(v), high = high_half(v);
  return join(angle_half(low, other_side(low)), angle_half(high, other_side(high)));
}

/// Returns the arccosine: 1 ulp; NaN if |v| > 1.
MOTES_INLINE Floats acos(Floats v) {
  const Doubles low = low_half(v), high = high_half(v);
  return join(angle_half(other_side(low), low), angle_half(other_side(high), high));
}

}  // namespace motes::MOTES_ISA
