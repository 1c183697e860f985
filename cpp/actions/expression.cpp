#include "actions/expression.h"

#include <stdexcept>
#include <string>

namespace motes::actions {
namespace {

struct Signature {
  int operands;
  Type operand;
  Type result;
};

Signature signature(Op op) {
  switch (op) {
    case Op::constant:
    case Op::column: return {0, Type::number, Type::number};
    case Op::inside: return {0, Type::number, Type::truth};
    case Op::negate:
    case Op::absolute:
    case Op::square_root:
    case Op::floor: return {1, Type::number, Type::number};
    case Op::less:
    case Op::less_equal:
    case Op::equal: return {2, Type::number, Type::truth};
    case Op::both:
    case Op::either: return {2, Type::truth, Type::truth};
    case Op::invert: return {1, Type::truth, Type::truth};
    default: return {2, Type::number, Type::number};
  }
}

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("expression must " + what); }

}  // namespace

Type check(const Expression& expression, int components, int shapes) {
  std::vector<Type> stack;
  for (const Instruction& instruction : expression) {
    if (static_cast<int>(instruction.op) >= kOps) refuse("use known operations");
    const int most = instruction.op == Op::column ? components : instruction.op == Op::inside ? shapes : 1;
    if (instruction.index < 0 || instruction.index >= most) refuse("name columns and shapes that exist");
    const Signature s = signature(instruction.op);
    for (int i = 0; i < s.operands; ++i) {
      if (stack.empty() || stack.back() != s.operand) refuse("give each operation numbers or truths as it needs");
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
