// Functions that scripts call with any number. Special cases are those of IEEE and the C library, the same on all
// machines.
#pragma once

#include "simd/elementary.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats floor(Floats v) {
  // Numbers of 2^23 and above are integers; below that the conversion is exact.
  const Floats whole = to_floats(to_ints(select(abs(v) < 8388608.0f, v, Floats{})));
  const Floats down = select(whole > v, whole - 1.0f, whole);
  return select(abs(v) < 8388608.0f, down, v);
}

/// Returns -1, 0 or 1; NaN for NaN.
MOTES_INLINE Floats sign(Floats v) { return select(v > 0.0f, all(1.0f), select(v < 0.0f, all(-1.0f), v)); }

/// Returns the natural logarithm: 1 ulp; -infinity for 0, NaN below.
MOTES_INLINE Floats natural_log(Floats v) {
  constexpr double kLn2 = 0.69314718055994531;
  const Floats found = join(log2_half(low_half(v)) * kLn2, log2_half(high_half(v)) * kLn2);
  return select(v >= 0.0f, found, all(__builtin_nanf("")));
}

/// Returns x^y: 1 ulp. For a negative x, y must be a whole number, else the result is NaN.
MOTES_INLINE Floats power(Floats x, Floats y) {
  const Floats size = pow(abs(x), y);
  const Mask negative = (Ints)x < 0;  // also -0
  const Mask whole = floor(y) == y;
  const Floats half = y * 0.5f;
  const Mask odd = whole & (abs(y) < 16777216.0f) & (floor(half) != half);
  const Mask infinite = abs(x) == __builtin_inff();
  const Floats signed_size = select(negative & odd, -size, size);
  return select((x < 0.0f) & ~whole & ~infinite, all(__builtin_nanf("")), signed_size);
}

// Returns the remainder of x / y with the sign of x, smaller than |y|. Exact: each iteration subtracts a multiple of at
// most 24 bits, whose product with y fits into a double.
MOTES_INLINE Doubles rest_half(Doubles x, Doubles y) {
  const Doubles size = abs(y);
  const auto far = [&] { return (Longs)(abs(x) >= size * 0x1p23) & (Longs)(size > 0.0) & (Longs)(abs(x) < 0x1p200); };
  const auto some = [](Longs mask) {
    std::int64_t bits = 0;
    for (std::size_t i = 0; i < kHalf; ++i) bits |= mask[i];
    return bits != 0;
  };
  for (Longs left = far(); some(left); left = far()) {
    const Doubles quotient = (Doubles)((Longs)(x / y) & ~0x1fffffffLL);
    x = select(left, x - quotient * y, x);
  }
  const Doubles quotient = x / y;
  Doubles whole = round(abs(quotient));
  whole = select(whole > abs(quotient), whole - 1.0, whole);
  const Doubles rest = abs(x) - whole * size;
  const Doubles found = select(abs(x) < size, abs(x), rest);  // also where y is infinite
  return (Doubles)((Longs)found | ((Longs)x & (Longs)all_doubles(-0.0)));
}

/// Returns the remainder of x / y between 0 and y, like Python's %. Exact except for one rounding; NaN if y is 0.
MOTES_INLINE Floats modulo(Floats x, Floats y) {
  const Doubles low_y = low_half(y), high_y = high_half(y);
  Doubles low = rest_half(low_half(x), low_y), high = rest_half(high_half(x), high_y);
  low = select((low != 0.0) & ((low < 0.0) != (low_y < 0.0)), low + low_y, low);
  high = select((high != 0.0) & ((high < 0.0) != (high_y < 0.0)), high + high_y, high);
  const Floats rest = join(low, high);
  const Ints sign_of_y = (Ints)y & (Ints)all(-0.0f);
  const Floats zero = (Floats)sign_of_y;
  const Floats known = select(rest == 0.0f, zero, rest);
  const Floats nothing = x * 0.0f;  // NaN where x is infinite or NaN
  return select((y == 0.0f) | (nothing != 0.0f) | (y != y), all(__builtin_nanf("")), known);
}

}  // namespace motes::MOTES_ISA
