#include "actions/expression.h"

#include <string>

#include "base/invalid_argument.h"

namespace motes::actions {
namespace {

struct Signature {
  int operands;
  Type operand;
  Type result;
  Type first = operand;  // of the operands
};

Signature signature(Op op) {
  switch (op) {
    case Op::constant:
    case Op::column:
    case Op::time: return {0, Type::number, Type::number};
    case Op::inside: return {0, Type::number, Type::truth};
    case Op::negate:
    case Op::absolute:
    case Op::square_root:
    case Op::square:
    case Op::floor:
    case Op::sign:
    case Op::sine:
    case Op::cosine:
    case Op::exponential:
    case Op::logarithm: return {1, Type::number, Type::number};
    case Op::less:
    case Op::less_equal:
    case Op::equal: return {2, Type::number, Type::truth};
    case Op::both:
    case Op::either: return {2, Type::truth, Type::truth};
    case Op::invert: return {1, Type::truth, Type::truth};
    case Op::mix:
    case Op::smoothstep: return {3, Type::number, Type::number};
    case Op::choose: return {3, Type::number, Type::number, Type::truth};
    case Op::noise: return {4, Type::number, Type::number};
    default: return {2, Type::number, Type::number};
  }
}

[[noreturn]] void refuse(const std::string& what) { throw base::InvalidArgument("expression", what); }

void check_index(const Instruction& instruction, int components, int shapes) {
  int least = 0, most = 1;
  if (instruction.op == Op::column) most = components;
  if (instruction.op == Op::inside) most = shapes;
  if (instruction.op == Op::noise) {
    least = kFields;
    most = kFields * (kOctaves + 1);
  }
  if (instruction.index < least || instruction.index >= most) refuse("name columns, shapes and fields that exist");
}

}  // namespace

Type check(const Expression& expression, int components, int shapes) {
  std::vector<Type> stack;
  for (const Instruction& instruction : expression) {
    if (static_cast<int>(instruction.op) >= kOps) refuse("use known operations");
    check_index(instruction, components, shapes);
    const Signature s = signature(instruction.op);
    for (int i = s.operands; i > 0; --i) {
      if (stack.empty() || stack.back() != (i == 1 ? s.first : s.operand))
        refuse("give each operation numbers or truths as it needs");
      stack.pop_back();
    }
    stack.push_back(s.result);
    if (static_cast<int>(stack.size()) > kDepth) {
      refuse("need at most " + std::to_string(kDepth) + " values at once, got more");
    }
  }
  if (stack.size() != 1) refuse("leave one value");
  return stack.back();
}

}  // namespace motes::actions
