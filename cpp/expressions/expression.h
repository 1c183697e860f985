// Expressions of columns as plain values: what `where=` tests, `set` computes and sums add up. The script compiles them
// into a list of instructions for a stack machine with block-wide values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/enumerators.h"

namespace motes::expressions {

enum class Op : std::uint8_t {
  // push a number
  constant,  // value
  column,  // index: a component of the schema, or one of the leaves of a law between particles
  time,  // at the start of the (sub)step, seconds
  // number(s) -> number
  negate,
  absolute,
  square_root,
  square,
  floor,
  sign,
  sine,
  cosine,
  exponential,
  logarithm,
  add,
  subtract,
  multiply,
  divide,
  minimum,
  maximum,
  power,
  modulo,  // with the divisor's sign
  angle,  // of the direction (second, first)
  step,  // 1 where the second is not below the first, else 0
  mix,  // a + (b - a) t
  smoothstep,  // from 0 at the first to 1 at the second, of the third
  noise,  // of x, y, z and time; index: kFields octaves + field
  // numbers -> truth value
  less,
  less_equal,
  equal,
  // push a truth value
  inside,  // index: whether this one of the action's shapes contains the particle
  // truth value(s) -> truth value
  both,
  either,
  invert,
  // truth value, two numbers -> number
  choose,
};
inline constexpr int kOps = base::enumerators<Op>();

struct Instruction {
  Op op = Op::constant;
  std::int32_t index = 0;
  float value = 0;

  bool operator==(const Instruction&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Instruction& instruction) {
  visit(instruction.op, instruction.index, instruction.value);
}

using Expression = std::vector<Instruction>;

/// The deepest stack that an expression may need.
inline constexpr int kDepth = 16;

/// Op::noise has this many fields, and at most this many octaves.
inline constexpr int kFields = 65536;
inline constexpr int kOctaves = 8;

enum class Type : std::uint8_t { number, truth };

/// How many values an operation takes from the stack. Kernels of every build call it: always inline, it cannot be
/// linked from another one.
[[gnu::always_inline]] constexpr int operands_of(Op op) {
  switch (op) {
    case Op::constant:
    case Op::column:
    case Op::time:
    case Op::inside: return 0;
    case Op::negate:
    case Op::absolute:
    case Op::square_root:
    case Op::square:
    case Op::floor:
    case Op::sign:
    case Op::sine:
    case Op::cosine:
    case Op::exponential:
    case Op::logarithm:
    case Op::invert: return 1;
    case Op::mix:
    case Op::smoothstep:
    case Op::choose: return 3;
    case Op::noise: return 4;
    default: return 2;
  }
}

/// The type of the value that the expression leaves on the stack. Throws std::invalid_argument where the expression is
/// invalid: an operand is missing or of the wrong type, an index does not exist, the stack is deeper than kDepth, or
/// not exactly one value is left.
Type check(const Expression& expression, int components, int shapes);

}  // namespace motes::expressions
