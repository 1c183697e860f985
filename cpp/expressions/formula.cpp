#include "expressions/formula.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <stdexcept>
#include <tuple>

namespace motes::expressions {
namespace {

// A value: an operation and the numbers of its operands.
struct Node {
  Op op = Op::constant;
  std::array<int, 4> from{-1, -1, -1, -1};
  std::int32_t index = 0;
  std::uint32_t bits = 0;  // of a constant

  auto operator<=>(const Node&) const = default;
};

bool is_constant(const Node& node) { return node.op == Op::constant || node.op == Op::time; }

class Compiler {
 public:
  Compiler(int columns, int position) : position_(position) { formula_.columns = columns; }

  Formula run(std::span<const Expression> expressions) {
    for (const Expression& expression : expressions) results_.push_back(number(expression));
    find_last_uses();
    plane_of_.assign(nodes_.size(), -1);
    formula_.planes = formula_.columns;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {  // no later step may write to these planes
      if (is_constant(nodes_[n])) write(static_cast<int>(n), formula_.constants);
    }
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].op == Op::column) plane_of_[n] = nodes_[n].index;
      if (plane_of_[n] < 0) write(static_cast<int>(n), formula_.steps);
    }
    for (const int result : results_) formula_.results.push_back(written(result));
    if (formula_.planes > UINT16_MAX) throw std::length_error("a law has too many values");
    return std::move(formula_);
  }

 private:
  // Returns the number of the value that an expression leaves; equal values have one number.
  int number(const Expression& expression) {
    std::vector<int> stack;
    for (const Instruction& instruction : expression) {
      Node node{instruction.op, {-1, -1, -1, -1}, instruction.index, 0};
      if (instruction.op == Op::constant) node.bits = std::bit_cast<std::uint32_t>(instruction.value);
      const auto count = static_cast<std::size_t>(operands_of(instruction.op));
      std::copy(stack.end() - static_cast<std::ptrdiff_t>(count), stack.end(), node.from.begin());
      stack.resize(stack.size() - count);
      if (instruction.op == Op::inside) {
        for (int c = 0; c < 3; ++c)
          node.from[static_cast<std::size_t>(c)] = known({Op::column, {-1, -1, -1, -1}, position_ + c});
      }
      stack.push_back(known(node));
    }
    return stack.back();
  }

  int known(const Node& node) {
    const auto [found, added] = numbers_.emplace(node, static_cast<int>(nodes_.size()));
    if (added) nodes_.push_back(node);
    return found->second;
  }

  void find_last_uses() {
    last_use_.assign(nodes_.size(), -1);
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      for (const int operand : nodes_[n].from) {
        if (operand >= 0) last_use_[static_cast<std::size_t>(operand)] = static_cast<int>(n);
      }
    }
    for (const int result : results_) last_use_[static_cast<std::size_t>(result)] = static_cast<int>(nodes_.size());
  }

  std::uint16_t plane(int node) const { return static_cast<std::uint16_t>(plane_of_[static_cast<std::size_t>(node)]); }

  // Returns the plane of a result. A result that is a column is copied, so that writing another result to that column
  // does not change it.
  std::uint16_t written(int result) {
    const Node& node = nodes_[static_cast<std::size_t>(result)];
    if (node.op != Op::column) return plane(result);
    formula_.steps.push_back({Op::column, static_cast<std::uint16_t>(formula_.planes), {plane(result)}, 0, 0});
    return static_cast<std::uint16_t>(formula_.planes++);
  }

  // Appends the step that computes a node. It may write where it reads: its loop loads before it stores.
  void write(int n, std::vector<FormulaStep>& steps) {
    const Node& node = nodes_[static_cast<std::size_t>(n)];
    FormulaStep step{node.op, 0, {}, node.index, std::bit_cast<float>(node.bits)};
    for (std::size_t k = 0; k < node.from.size(); ++k) {
      if (node.from[k] < 0) continue;
      step.from[k] = plane(node.from[k]);
      const Node& operand = nodes_[static_cast<std::size_t>(node.from[k])];
      const bool again =
          std::count(node.from.begin(), node.from.begin() + static_cast<std::ptrdiff_t>(k), node.from[k]) > 0;
      const bool free = !again && !is_constant(operand) && operand.op != Op::column;
      if (free && last_use_[static_cast<std::size_t>(node.from[k])] == n) free_.push_back(step.from[k]);
    }
    if (free_.empty() || is_constant(node)) {
      step.to = static_cast<std::uint16_t>(formula_.planes++);
    } else {
      step.to = free_.back();
      free_.pop_back();
    }
    plane_of_[static_cast<std::size_t>(n)] = step.to;
    steps.push_back(step);
  }

  int position_;
  std::map<Node, int> numbers_;
  std::vector<Node> nodes_;  // operands come before the nodes that use them
  std::vector<int> results_, last_use_, plane_of_;
  std::vector<std::uint16_t> free_;
  Formula formula_;
};

}  // namespace

Formula compile(std::span<const Expression> expressions, int columns, int position) {
  return Compiler(columns, position).run(expressions);
}

}  // namespace motes::expressions
