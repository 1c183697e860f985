// Expressions over a block: each instruction is a loop, so an instruction costs only its arithmetic.
#pragma once

#include "actions/expression.h"
#include "actions/lanes.h"
#include "particles/noise.h"
#include "simd/ieee.h"

namespace motes::MOTES_ISA {

/// The values of one stack level for a block.
inline constexpr std::size_t kLevel = particles::kBlock + particles::kPadding;

template <class Compute>
MOTES_INLINE void each(std::size_t count, const Compute& compute) {
  for (std::size_t i = 0; i < count; i += kLanes) compute(i);
}

MOTES_INLINE void push_inside(const shapes::Shape& shape, const actions::Block& b, float* to) {
  visit(shape, [&](const auto& lanes) __attribute__((always_inline)) {
    each(b.count, [&](std::size_t i) __attribute__((always_inline)) {
      store(to + i, (Floats)lanes.contains(load3(b, kPositionAt, i)));
    });
  });
}

template <class Compute>
MOTES_INLINE void binary(std::size_t count, float* a, const float* b, const Compute& compute) {
  each(count, [&](std::size_t i) __attribute__((always_inline)) { store(a + i, compute(load(a + i), load(b + i))); });
}

template <class Compute>
MOTES_INLINE void unary(std::size_t count, float* a, const Compute& compute) {
  each(count, [&](std::size_t i) __attribute__((always_inline)) { store(a + i, compute(load(a + i))); });
}

template <class Compute>
MOTES_INLINE void ternary(std::size_t count, float* a, const Compute& compute) {
  each(count, [&](std::size_t i) __attribute__((always_inline)) {
    store(a + i, compute(load(a + i), load(a + kLevel + i), load(a + 2 * kLevel + i)));
  });
}

MOTES_INLINE Floats smoothstep(Floats low, Floats high, Floats x) {
  const Floats t = min(max((x - low) / (high - low), Floats{}), all(1.0f));
  return select(x == x, t * t * (3.0f - 2.0f * t), x);
}

/// The root mean square is 1/3 for any number of octaves, each with half the size and half the strength of the one
/// before.
MOTES_INLINE void push_noise(std::size_t count, float* a, int index) {
  const int octaves = index / actions::kFields;
  const auto field = static_cast<std::uint32_t>(index % actions::kFields);
  each(count, [&](std::size_t i) __attribute__((always_inline)) {
    const Floats3 p = {load(a + i), load(a + kLevel + i), load(a + 2 * kLevel + i)};
    store(a + i, noise(p, load(a + 3 * kLevel + i), octaves, field));
  });
}

#define MOTES_BINARY(expression) \
  binary(n, a, top, [](Floats x, Floats y) __attribute__((always_inline)) { return (Floats)(expression); })
#define MOTES_UNARY(expression) \
  unary(n, top, [](Floats x) __attribute__((always_inline)) { return (Floats)(expression); })
#define MOTES_TERNARY(expression) \
  ternary(n, a - kLevel, [](Floats x, Floats y, Floats z) __attribute__((always_inline)) { return (expression); })

/// Runs checked instructions at `time`, seconds; the result is at the first level of the stack (a truth value: all bits
/// set or none).
inline void evaluate(const actions::Instruction* code, std::size_t length, const shapes::Shape* shapes,
                     const actions::Block& b, float time, float* stack) {
  using actions::Op;
  const std::size_t n = b.count;
  float* next = stack;
  for (std::size_t k = 0; k < length; ++k) {
    const actions::Instruction& instruction = code[k];
    float* top = next - kLevel;
    float* a = top - kLevel;
    switch (instruction.op) {
      case Op::constant:
        each(n, [&](std::size_t i) __attribute__((always_inline)) { store(next + i, all(instruction.value)); });
        next += kLevel;
        continue;
      case Op::column:
        each(n, [&](std::size_t i)
                    __attribute__((always_inline)) { store(next + i, load(b.component[instruction.index] + i)); });
        next += kLevel;
        continue;
      case Op::time:
        each(n, [&](std::size_t i) __attribute__((always_inline)) { store(next + i, all(time)); });
        next += kLevel;
        continue;
      case Op::inside:
        push_inside(shapes[instruction.index], b, next);
        next += kLevel;
        continue;
      case Op::negate: MOTES_UNARY(-x); continue;
      case Op::absolute: MOTES_UNARY(abs(x)); continue;
      case Op::square_root: MOTES_UNARY(sqrt(x)); continue;
      case Op::square: MOTES_UNARY(x * x); continue;
      case Op::floor: MOTES_UNARY(floor(x)); continue;
      case Op::sign: MOTES_UNARY(sign(x)); continue;
      case Op::sine: MOTES_UNARY(sin(x)); continue;
      case Op::cosine: MOTES_UNARY(cos(x)); continue;
      case Op::exponential: MOTES_UNARY(exp(x)); continue;
      case Op::logarithm: MOTES_UNARY(natural_log(x)); continue;
      case Op::invert: MOTES_UNARY(~(Mask)x); continue;
      case Op::add: MOTES_BINARY(x + y); break;
      case Op::subtract: MOTES_BINARY(x - y); break;
      case Op::multiply: MOTES_BINARY(x * y); break;
      case Op::divide: MOTES_BINARY(x / y); break;
      case Op::minimum: MOTES_BINARY(select(x == x, select(y == y, min(x, y), y), x)); break;
      case Op::maximum: MOTES_BINARY(select(x == x, select(y == y, max(x, y), y), x)); break;
      case Op::power: MOTES_BINARY(power(x, y)); break;
      case Op::modulo: MOTES_BINARY(modulo(x, y)); break;
      case Op::angle: MOTES_BINARY(atan2(x, y)); break;
      case Op::step: MOTES_BINARY(only(y >= x, all(1.0f))); break;
      case Op::less: MOTES_BINARY(x < y); break;
      case Op::less_equal: MOTES_BINARY(x <= y); break;
      case Op::equal: MOTES_BINARY(x == y); break;
      case Op::both: MOTES_BINARY((Mask)x & (Mask)y); break;
      case Op::either: MOTES_BINARY((Mask)x | (Mask)y); break;
      case Op::mix:
        MOTES_TERNARY(x + (y - x) * z);
        next = a;
        continue;
      case Op::smoothstep:
        MOTES_TERNARY(smoothstep(x, y, z));
        next = a;
        continue;
      case Op::choose:
        MOTES_TERNARY(select((Mask)x, y, z));
        next = a;
        continue;
      case Op::noise:
        push_noise(n, a - 2 * kLevel, instruction.index);
        next = a - kLevel;
        continue;
    }
    next = top;
  }
}
#undef MOTES_BINARY
#undef MOTES_UNARY
#undef MOTES_TERNARY

/// set: attribute = values, computed from the particle as it was before the action. A component whose result is not
/// finite (a division by 0, the root of a negative number) keeps its old value.
inline void set(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  for (int c = 0; c < p.width; ++c) {
    float* result = p.scratch + static_cast<std::size_t>(c) * kLevel;
    evaluate(p.code[c], p.length[c], p.shape, b, static_cast<float>(s.time), result);
  }
  for (int c = 0; c < p.width; ++c) {
    const float* result = p.scratch + static_cast<std::size_t>(c) * kLevel;
    float* plane = b.component[p.target + c];
    each(b.count, [&](std::size_t i) __attribute__((always_inline)) {
      const Floats value = load(result + i);
      store(plane + i, select(abs(value) <= __FLT_MAX__, value, load(plane + i)));
    });
  }
}

}  // namespace motes::MOTES_ISA
