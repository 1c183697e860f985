// Expressions compiled together, for hundreds of particles or pairs at a time: each operation is a loop over planes of
// values, and common subexpressions are computed once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "expressions/expression.h"

namespace motes::expressions {

/// plane[to] = op(plane[from[0]], ...). For Op::inside, `from` are the planes of a position.
struct FormulaStep {
  Op op = Op::constant;
  std::uint16_t to = 0;
  std::uint16_t from[4] = {};
  std::int32_t index = 0;  // as in Instruction
  float value = 0;
};

/// Compiled expressions. Planes are numbered: first the columns, which are given, then those that the steps write.
///
///     columns | constants (the same for all: written once) | work, which later steps use again
struct Formula {
  int columns = 0;
  int planes = 0;  // total, with the columns
  std::vector<FormulaStep> constants;
  std::vector<FormulaStep> steps;
  std::vector<std::uint16_t> results;  // each expression's plane

  /// Planes that need memory.
  int written() const { return planes - columns; }
};

/// Compiles checked expressions over these columns. `position`: the first of the three columns that shapes look in.
Formula compile(std::span<const Expression> expressions, int columns, int position = 0);

}  // namespace motes::expressions
