// Evaluates expressions over a block of particles: conditions, values of actions, terms of sums.
//
// set: attribute = values. law: an action that the script defines; the values of its expressions are added to
// attributes or replace them. gravity_by, wind_by, damping_by, rotational_damping_by: the actions without `_by`, with
// an expression for each of their numbers; where one is not finite (a speed: NaN), nothing changes, and drag and
// damping below 0 count as 0.
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

/// Adds finite values to a column: rates times `dt` (seconds), or changes (dt = 1).
MOTES_INLINE void add_finite(float* column, const float* value, std::size_t count, float dt) {
  each(count, [&](std::size_t i) __attribute__((always_inline)) {
    const Floats v = load(value + i) * dt;
    store(column + i, load(column + i) + only(abs(v) <= __FLT_MAX__, v));
  });
}

/// Runs a law. All values are computed from the particle as it was before the action.
inline void law(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const actions::LawCode& law = *p.bound.law;
  for (std::size_t c = 0; c < law.columns; ++c) law.plane[c] = b.component[c];
  write_constants(law.constants, law.constant_count, law.plane, b.count, static_cast<float>(s.time));
  run_steps(law.steps, law.step_count, law.plane, b.count,
            [&](const expressions::FormulaStep& step, const float* const* position, float* to)
                __attribute__((always_inline)) {
                  if (step.op == expressions::Op::id) return write_ids(b.ids, step.index, b.count, to);
                  inside(p.shape[step.index], b.count, position, to);
                });
  for (std::size_t k = 0; k < law.outcome_count; ++k) {
    const actions::LawResult& outcome = law.outcomes[k];
    float* column = b.component[outcome.component];
    const float* value = law.plane[outcome.plane];
    if (outcome.adds) {
      add_finite(column, value, b.count, outcome.rate ? s.dt : 1.0f);
    } else {
      keep_finite(column, value, b.count);
    }
  }
}

inline void gravity_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Values values(p, b, s);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 acceleration = values.at3(0, i);
    store3(b, kVelocityAt, i, load3(b, kVelocityAt, i) + only(finite(acceleration), acceleration * s.dt));
  }
}

inline void wind_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const Values values(p, b, s);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 air = values.at3(0, i), v = load3(b, kVelocityAt, i);
    const Floats drag = values.at(3, i);
    const Mask acts = finite(air) & (drag > 0.0f) & (drag <= __FLT_MAX__);
    store3(b, kVelocityAt, i, select(acts, v + (air - v) * part_gone(drag * s.dt), v));
  }
}

/// Slows the vectors down whose first component is at `at`.
MOTES_INLINE void damp_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s, int at) {
  const Values values(p, b, s);
  const auto lost = [&](Floats kept) { return (1.0f - max(kept, Floats{})) * s.dt; };
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 v = load3(b, at, i), kept = values.at3(0, i);
    const Floats low = values.at(3, i), high = values.at(4, i), speed2 = dot(v, v);
    const Mask acts = finite(kept) & (speed2 >= low * low) & (speed2 <= high * high);
    store3(b, at, i, v - only(acts, {v.x * lost(kept.x), v.y * lost(kept.y), v.z * lost(kept.z)}));
  }
}

inline void damping_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  damp_by(p, b, s, kVelocityAt);
}

inline void rotational_damping_by(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  damp_by(p, b, s, kSpinAt);
}

}  // namespace motes::MOTES_ISA
