#include "expressions/expression.h"

#include <algorithm>
#include <string>

#include "base/invalid_argument.h"

namespace motes::expressions {
namespace {

struct Signature {
  Type operand = Type::number;
  Type result = Type::number;
  Type first = operand;  // the first operand's type
};

Signature signature(Op op) {
  switch (op) {
    case Op::inside:
    case Op::less:
    case Op::less_equal:
    case Op::equal: return {Type::number, Type::truth};
    case Op::both:
    case Op::either:
    case Op::invert: return {Type::truth, Type::truth};
    case Op::choose: return {Type::number, Type::number, Type::truth};
    default: return {};
  }
}

[[noreturn]] void refuse(const std::string& what) { throw base::InvalidArgument("expression", what); }

void check_index(const Instruction& instruction, int components, int shapes) {
  int least = 0, most = 1;
  if (instruction.op == Op::column) most = components;
  if (instruction.op == Op::inside) most = shapes;
  if (instruction.op == Op::id) {
    least = kHighId;
    most = kMostModulo + 1;
  }
  if (instruction.op == Op::noise) {
    least = kFields;
    most = kFields * (kOctaves + 1);
  }
  if (instruction.index < least || instruction.index >= most) refuse("name columns, shapes and fields that exist");
}

}  // namespace

bool names_ids(const Expression& expression) {
  return std::any_of(expression.begin(), expression.end(), [](const Instruction& i) { return i.op == Op::id; });
}

Type check(const Expression& expression, int components, int shapes) {
  std::vector<Type> stack;
  for (const Instruction& instruction : expression) {
    if (static_cast<int>(instruction.op) >= kOps) refuse("use known operations");
    check_index(instruction, components, shapes);
    const Signature s = signature(instruction.op);
    for (int i = operands_of(instruction.op); i > 0; --i) {
      if (stack.empty() || stack.back() != (i == 1 ? s.first : s.operand))
        refuse("give each operation operands of the right type");
      stack.pop_back();
    }
    stack.push_back(s.result);
    if (static_cast<int>(stack.size()) > kDepth) {
      refuse("need at most " + std::to_string(kDepth) + " values at once, got more");
    }
  }
  if (stack.size() != 1) refuse("have exactly one result");
  return stack.back();
}

}  // namespace motes::expressions
