// An action over particles as a plain value (paper 3.1.5), and the facts about each kind of action.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "actions/expression.h"
#include "actions/tables.h"
#include "particles/schema.h"
#include "shapes/shape.h"

namespace motes::actions {

enum class Kind : std::uint8_t {
#define MOTES_ACTION(name, ...) name,
#define MOTES_MEETING MOTES_ACTION
#include "actions/list.inc"
#undef MOTES_MEETING
#undef MOTES_ACTION
};

inline constexpr int kKinds = 0
#define MOTES_ACTION(name, ...) +1  // NOLINT(bugprone-macro-parentheses): a summand
#define MOTES_MEETING MOTES_ACTION
#include "actions/list.inc"
#undef MOTES_MEETING
#undef MOTES_ACTION
    ;

/// What a script recorded: the kind; its numbers in the order of Facts::numbers, or the knots of its ramp; its shapes.
struct Action {
  Kind kind = Kind::move;
  std::vector<double> numbers;
  std::vector<shapes::Shape> shapes;   // the action's own, then those that its expressions use
  Expression where{};                  // a truth value; empty: all particles
  std::int32_t target = -1;            // set: the attribute
  std::vector<Expression> values{};    // set: one per component
  std::int32_t other = -1;             // between particles: the other system, where two meet
  std::uint64_t ties = 0;              // tie: the key of the ties
  TableKey table = 0;                  // field, follow_path: the key of their numbers

  bool operator==(const Action&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Action& action) {
  visit(action.kind, action.numbers, action.shapes, action.where, action.target, action.values, action.other,
        action.ties, action.table);
}

/// One number of an action, or a vector of them: its name in the Python API and the values that it may have.
struct Number {
  enum class Rule : std::uint8_t { none, whole, axis, not_below_last };
  const char* name;
  double low;
  double high;
  int count = 1;
  Rule rule = Rule::none;  // axis: not all zero; not_below_last: at least the number before it
};

/// What the recorder, the checks and the compiler of programs need to know about a kind. Attributes are bit masks of
/// particles::Builtin indices.
struct Facts {
  const char* name = "";
  std::vector<Number> numbers{};
  int shapes = 0;
  std::uint32_t reads = 0;
  std::uint32_t writes = 0;
  bool meets = false;  // the shape must have a surface that a particle can meet
  int ramp = 0;  // the numbers are knots, as many as given: age / lifetime, then this many numbers of the value
  int table = 0;  // it has a table, whose entries have this many numbers
  bool draws = false;  // its last shape is only drawn from
  bool between = false;  // between particles: a meeting, which has no kernel over a block
};

const Facts& facts(Kind kind);

/// The kind with that name; throws std::invalid_argument where no action has this name.
Kind kind_of(const std::string& name);

/// Attributes that the action touches in a system of this schema, including those that its expressions read: one bit
/// each.
std::uint64_t reads(const Action& action, const particles::Schema& schema);
std::uint64_t writes(const Action& action, const particles::Schema& schema);
/// Only the attributes that its expressions read.
std::uint64_t named(const Action& action, const particles::Schema& schema);

/// Attributes that an expression reads, one bit each.
std::uint64_t columns_of(const Expression& expression, const particles::Schema& schema);

/// Whether the action, or a condition, reads or writes a *_b attribute.
bool uses_copies(const Action& action, const particles::Schema& schema);
bool uses_copies(const Expression& expression, const particles::Schema& schema);

/// Throws std::invalid_argument, naming the argument, its value and what is allowed.
void check(const Action& action);
/// The same for its expressions, whose columns are those of a schema.
void check(const Action& action, const particles::Schema& schema);

/// The same for a condition on its own; an empty one stands for no condition.
void check_condition(const Expression& where, const std::vector<shapes::Shape>& shapes,
                     const particles::Schema& schema);

}  // namespace motes::actions
