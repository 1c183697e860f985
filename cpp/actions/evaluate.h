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

/// Writes ids as Op::id's index says. In whole numbers, so the result is exact up to its conversion.
MOTES_OUTLINE void write_ids(const particles::Ids& ids, std::int32_t index, std::size_t count, float* to) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t id = (ids.upper == nullptr ? 0 : std::uint64_t{ids.upper[i]} << 32) | ids.lower[i];
    if (index == expressions::kWholeId) {
      to[i] = static_cast<float>(id);
    } else if (index == expressions::kHighId) {
      to[i] = static_cast<float>(id / expressions::kMostModulo);
    } else {
      to[i] = static_cast<float>(static_cast<std::uint32_t>(id % static_cast<std::uint32_t>(index)));
    }
  }
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
      case Op::id: write_ids(b.ids, instruction.index, b.count, next); break;
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

/// The values of an action's expressions, one plane each, computed from the particles as they were before the action.
class Values {
 public:
  Values(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) : first_(p.scratch) {
    const actions::ValuesCode& code = *p.bound.values;
    for (int c = 0; c < code.width; ++c) {
      evaluate(code.code[c], code.length[c], p.shape, b, static_cast<float>(s.time), first_ + plane(c));
    }
  }

  const float* operator[](int value) const { return first_ + plane(value); }
  MOTES_INLINE Floats at(int value, std::size_t i) const { return load(first_ + plane(value) + i); }
  MOTES_INLINE Floats3 at3(int value, std::size_t i) const {
    return {at(value, i), at(value + 1, i), at(value + 2, i)};
  }

 private:
  static std::size_t plane(int value) { return static_cast<std::size_t>(value) * kLevel; }

  float* first_;
};

/// set: attribute = values.
inline void set(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Values values(p, b, s);
  const actions::ValuesCode& to = *p.bound.values;
  for (int c = 0; c < to.width; ++c) keep_finite(b.component[to.first + c], values[c], b.count);
}

}  // namespace motes::MOTES_ISA
