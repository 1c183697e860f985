// The operations of expressions on planes of values: each is a loop, so it costs only its arithmetic.
#pragma once

#include "expressions/formula.h"
#include "particles/noise.h"
#include "simd/ieee.h"

namespace motes::MOTES_ISA {

template <class Compute>
MOTES_INLINE void each(std::size_t count, const Compute& compute) {
  for (std::size_t i = 0; i < count; i += kLanes) compute(i);
}

MOTES_INLINE Floats smoothstep(Floats low, Floats high, Floats x) {
  const Floats t = min(max((x - low) / (high - low), Floats{}), all(1.0f));
  return select(x == x, t * t * (3.0f - 2.0f * t), x);
}

MOTES_OUTLINE void fill(float* to, float value, std::size_t count) {
  each(count, [&](std::size_t i) __attribute__((always_inline)) { store(to + i, all(value)); });
}

/// Computes noise whose root mean square is 1/3 for any number of octaves; each octave has half the scale and half the
/// strength of the one before it.
MOTES_INLINE void noise_of(std::size_t count, float* to, const float* const (&from)[4], int index) {
  const int octaves = index / expressions::kFields;
  const auto field = static_cast<std::uint32_t>(index % expressions::kFields);
  each(count, [&](std::size_t i) __attribute__((always_inline)) {
    const Floats3 p = {load(from[0] + i), load(from[1] + i), load(from[2] + i)};
    store(to + i, noise(p, load(from[3] + i), octaves, field));
  });
}

#define MOTES_LOOP(operands, expression)                          \
  each(count, [&](std::size_t i) __attribute__((always_inline)) { \
    operands;                                                     \
    store(to + i, (Floats)(expression));                          \
  })
#define MOTES_UNARY(expression) MOTES_LOOP(const Floats x = load(from[0] + i), expression)
#define MOTES_BINARY(expression) \
  MOTES_LOOP(const Floats x = load(from[0] + i); const Floats y = load(from[1] + i), expression)
#define MOTES_TERNARY(expression)                                                    \
  MOTES_LOOP(const Floats x = load(from[0] + i); const Floats y = load(from[1] + i); \
             const Floats z = load(from[2] + i), expression)

/// Computes an operation for whole vectors of `count` values. `to` may be the plane of an operand. A truth value has
/// all bits set or none.
MOTES_OUTLINE void operate(expressions::Op op, std::int32_t index, std::size_t count, float* to,
                           const float* const (&from)[4]) {
  using expressions::Op;
  switch (op) {
    case Op::constant:
    case Op::time:
    case Op::id:
    case Op::inside: return;  // computed by the caller
    case Op::column: MOTES_UNARY(x); return;
    case Op::negate: MOTES_UNARY(-x); return;
    case Op::absolute: MOTES_UNARY(abs(x)); return;
    case Op::square_root: MOTES_UNARY(sqrt(x)); return;
    case Op::square: MOTES_UNARY(x * x); return;
    case Op::floor: MOTES_UNARY(floor(x)); return;
    case Op::sign: MOTES_UNARY(sign(x)); return;
    case Op::sine: MOTES_UNARY(sin(x)); return;
    case Op::cosine: MOTES_UNARY(cos(x)); return;
    case Op::exponential: MOTES_UNARY(exp(x)); return;
    case Op::logarithm: MOTES_UNARY(natural_log(x)); return;
    case Op::invert: MOTES_UNARY(~(Mask)x); return;
    case Op::add: MOTES_BINARY(x + y); return;
    case Op::subtract: MOTES_BINARY(x - y); return;
    case Op::multiply: MOTES_BINARY(x * y); return;
    case Op::divide: MOTES_BINARY(x / y); return;
    case Op::minimum: MOTES_BINARY(select(x == x, select(y == y, min(x, y), y), x)); return;
    case Op::maximum: MOTES_BINARY(select(x == x, select(y == y, max(x, y), y), x)); return;
    case Op::power: MOTES_BINARY(power(x, y)); return;
    case Op::modulo: MOTES_BINARY(modulo(x, y)); return;
    case Op::angle: MOTES_BINARY(atan2(x, y)); return;
    case Op::step: MOTES_BINARY(only(y >= x, all(1.0f))); return;
    case Op::less: MOTES_BINARY(x < y); return;
    case Op::less_equal: MOTES_BINARY(x <= y); return;
    case Op::equal: MOTES_BINARY(x == y); return;
    case Op::both: MOTES_BINARY((Mask)x & (Mask)y); return;
    case Op::either: MOTES_BINARY((Mask)x | (Mask)y); return;
    case Op::mix: MOTES_TERNARY(x + (y - x) * z); return;
    case Op::smoothstep: MOTES_TERNARY(smoothstep(x, y, z)); return;
    case Op::choose: MOTES_TERNARY(select((Mask)x, y, z)); return;
    case Op::noise: noise_of(count, to, from, index); return;
  }
}
#undef MOTES_LOOP
#undef MOTES_UNARY
#undef MOTES_BINARY
#undef MOTES_TERNARY

/// Writes the planes whose values are all equal: of constants, and of the time in seconds.
MOTES_INLINE void write_constants(const expressions::FormulaStep* steps, std::size_t length, float* const* plane,
                                  std::size_t count, float time) {
  for (std::size_t k = 0; k < length; ++k) {
    fill(plane[steps[k].to], steps[k].op == expressions::Op::time ? time : steps[k].value, count);
  }
}

/// Runs the steps; special(step, from, to) computes ids, and whether positions are in a shape.
template <class Special>
MOTES_INLINE void run_steps(const expressions::FormulaStep* steps, std::size_t length, float* const* plane,
                            std::size_t count, const Special& special) {
  for (std::size_t k = 0; k < length; ++k) {
    const expressions::FormulaStep& step = steps[k];
    const float* const from[4] = {plane[step.from[0]], plane[step.from[1]], plane[step.from[2]], plane[step.from[3]]};
    if (step.op == expressions::Op::inside || step.op == expressions::Op::id) {
      special(step, from, plane[step.to]);
    } else {
      operate(step.op, step.index, count, plane[step.to], from);
    }
  }
}

}  // namespace motes::MOTES_ISA
