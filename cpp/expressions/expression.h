// Expressions of columns as plain values, for `where=`, `set` and sums. The script compiles them into a list of
// instructions for a stack machine with block-wide values.
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
  id,  // of the particle; index n: modulo n, exact; kWholeId: rounded to float32; kHighId: floor(id / kMostModulo)
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
  angle,  // atan2(first, second)
  step,  // 1 if second >= first, else 0
  mix,  // a + (b - a) t
  smoothstep,  // of the third: from 0 at the first to 1 at the second
  noise,  // of x, y, z and time; index: kFields * octaves + field
  // numbers -> truth value
  less,
  less_equal,
  equal,
  // push a truth value
  inside,  // index: the action's shape that may contain the particle
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

/// The maximum stack depth of an expression.
inline constexpr int kDepth = 16;

/// Op::noise has this many fields, and at most this many octaves.
inline constexpr int kFields = 65536;
inline constexpr int kOctaves = 8;

/// Op::id has an index of 1..kMostModulo, which float32 represents exactly, or one of these.
inline constexpr int kWholeId = 0, kHighId = -1;
inline constexpr int kMostModulo = 1 << 24;

/// Returns whether the expression reads ids, which only expressions of one particle can.
bool names_ids(const Expression& expression);

enum class Type : std::uint8_t { number, truth };

/// Returns how many values an operation takes from the stack. Always inline, so that a kernel never links a copy that
/// was compiled for another instruction set.
[[gnu::always_inline]] constexpr int operands_of(Op op) {
  switch (op) {
    case Op::constant:
    case Op::column:
    case Op::time:
    case Op::id:
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

/// Returns the type of the value that the expression leaves on the stack. Throws std::invalid_argument if an operand is
/// missing or of the wrong type, an index does not exist, the stack is deeper than kDepth, or not exactly one value is
/// left.
Type check(const Expression& expression, int components, int shapes);

}  // namespace motes::expressions
