// Elementary functions of lanes, from + - * / and sqrt alone: the C library's differ between processors.
#pragma once

#include "simd/simd.h"

namespace motes::MOTES_ISA {

/// cos and sin of `turn` whole turns, for turn in [0, 1]. Error below 1e-7.
MOTES_INLINE void cos_sin_turn(Floats turn, Floats& cosine, Floats& sine) {
  const Floats quarters = turn * 4.0f;
  const Ints nearest = to_ints(quarters + 0.5f);
  const Floats r = (quarters - to_floats(nearest)) * 1.57079632679f;  // within +- pi / 4
  const Floats rr = r * r;
  // Minimax polynomials on +- pi/4 (coefficients as in the Cephes library, S. Moshier).
  const Floats s = r + r * rr * (-1.6666654611e-1f + rr * (8.3321608736e-3f + rr * -1.9515295891e-4f));
  const Floats c =
      1.0f - 0.5f * rr + rr * rr * (4.166664568298827e-2f + rr * (-1.388731625493765e-3f + rr * 2.443315711809948e-5f));
  const Mask odd = (nearest & 1) != 0;
  const Floats x = select(odd, s, c);
  const Floats y = select(odd, c, s);
  cosine = select(((nearest + 1) & 2) != 0, -x, x);
  sine = select((nearest & 2) != 0, -y, y);
}

/// Natural logarithm for normal positive numbers. Error below 2e-7 relative to max(1, |log|).
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

/// Cube root of numbers >= 0. Error below 2e-7 relative.
MOTES_INLINE Floats cube_root(Floats v) {
  const Floats third = to_floats((Ints)v) * (1.0f / 3.0f);
  Floats y = (Floats)(to_ints(third) + 0x2a514067);  // a third of the exponent: within 6 %
  for (int i = 0; i < 3; ++i) y = y - (y * y * y - v) / (3.0f * y * y);
  return select(v > 0.0f, y, Floats{});
}

}  // namespace motes::MOTES_ISA
