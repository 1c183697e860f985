// Evaluates expressions over a block of particles: conditions, values of `set` and `law`, terms of sums.
#pragma once

#include "actions/lanes.h"
#include "expressions/operate.h"

namespace motes::MOTES_ISA {

/// Floats per stack level of a block.
inline constexpr std::size_t kLevel = actions::kPlane;

/// Writes which positions are in a shape, as masks.
MOTES_OUTLINE void inside(const shapes::Shape& shape, std::size_t count, const float* const* position, float* to) {
  visit(shape, [&](const auto& lanes) __attribute__((always_inline)) {
    each(count, [&](std::size_t i) __attribute__((always_inline)) {
      store(to + i, (Floats)lanes.contains({load(position[0] + i), load(position[1] + i), load(position[2] + i)}));
    });
  });
}

/// Runs checked instructions at `time` (seconds) and leaves the result at the first level of the stack. Truth values
/// have all bits set or none.
inline void evaluate(const expressions::Instruction* code, std::size_t length, const shapes::Shape* shapes,
                     const actions::Block& b, float time, float* stack) {
  using expressions::Op;
  float* next = stack;
  for (std::size_t k = 0; k < length; ++k) {
    const expressions::Instruction& instruction = code[k];
    switch (instruction.op) {
      case Op::constant: fill(next, instruction.value, b.count); break;
      case Op::time: fill(next, time, b.count); break;
      case Op::column: {
        const float* column = b.component[instruction.index];
        each(b.count, [&](std::size_t i) __attribute__((always_inline)) { store(next + i, load(column + i)); });
        break;
      }
      case Op::inside: inside(shapes[instruction.index], b.count, b.component + kPositionAt, next); break;
      default:
        next -= static_cast<std::size_t>(expressions::operands_of(instruction.op)) * kLevel;
        operate(instruction.op, instruction.index, b.count, next,
                {next, next + kLevel, next + 2 * kLevel, next + 3 * kLevel});
    }
    next += kLevel;
  }
}

/// Writes values to a column, except where they are not finite (division by 0, root of a negative number).
MOTES_INLINE void keep_finite(float* column, const float* value, std::size_t count) {
  each(count, [&](std::size_t i) __attribute__((always_inline)) {
    const Floats v = load(value + i);
    store(column + i, select(abs(v) <= __FLT_MAX__, v, load(column + i)));
  });
}

/// set: attribute = values, computed from the particle as it was before the action.
inline void set(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const actions::AssignmentCode& to = *p.bound.assignment;
  for (int c = 0; c < to.width; ++c) {
    float* result = p.scratch + static_cast<std::size_t>(c) * kLevel;
    evaluate(to.code[c], to.length[c], p.shape, b, static_cast<float>(s.time), result);
  }
  for (int c = 0; c < to.width; ++c) {
    keep_finite(b.component[to.first + c], p.scratch + static_cast<std::size_t>(c) * kLevel, b.count);
  }
}

}  // namespace motes::MOTES_ISA
