// An action over particles as a plain value (paper 3.1.5), and the facts about each kind of action.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "actions/numbers.h"
#include "actions/tables.h"
#include "expressions/expression.h"
#include "particles/schema.h"
#include "shapes/shape.h"

namespace motes::actions {

using expressions::Expression;
using expressions::Instruction;
using expressions::Op;

/// What an expression of `interact` reads, as columns: a component of one of the pair, or of what they are to each
/// other.
struct Leaf {
  enum class Of : std::uint8_t { own, other, distance, normal, state };
  Of of = Of::own;
  std::int32_t attribute = 0;  // own, other
  std::int32_t component = 0;  // of the attribute, the vector or the state

  bool operator==(const Leaf&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Leaf& leaf) {
  visit(leaf.of, leaf.attribute, leaf.component);
}

/// Where a value of `law` or `interact` goes.
struct Result {
  enum class How : std::uint8_t { rate, change, value, state };
  How how = How::rate;  // rate: added times dt; change: added; value: takes the attribute's place
  std::int32_t attribute = 0;
  std::int32_t component = 0;  // of the attribute or the state

  bool operator==(const Result&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Result& result) {
  visit(result.how, result.attribute, result.component);
}

/// What a script recorded: the kind; its numbers in the order of its struct in `numbers`, or the knots of its ramp; its
/// shapes.
struct Action {
  Kind kind = Kind::move;
  std::vector<double> numbers;
  std::vector<shapes::Shape> shapes;   // the action's own, then those that its expressions use
  Expression where{};                  // a truth value; empty: all particles
  std::int32_t target = -1;            // set: the attribute
  std::vector<Expression> values{};    // set: one per component; law, interact: one per result
  std::int32_t other = -1;             // between particles: the other system, where two meet
  bool second = false;                 // between two systems: the entry in the other one's list
  std::uint64_t ties = 0;              // tie: the key of the ties
  TableKey table = 0;                  // field, follow_path: the key of their numbers
  std::vector<Leaf> leaves{};          // interact: the columns of its values
  std::vector<Result> results{};       // law, interact

  bool operator==(const Action&) const = default;
};

/// Returns an action of the kind whose numbers these are.
template <template <class> class Numbers>
Action make(const Numbers<double>& numbers, std::vector<shapes::Shape> shapes = {}) {
  Action action{Numbers<double>::kKind, {}, std::move(shapes)};
  if constexpr (!std::is_empty_v<Numbers<double>>) {
    const auto values = std::bit_cast<std::array<double, sizeof numbers / sizeof(double)>>(numbers);
    action.numbers.assign(values.begin(), values.end());
  }
  return action;
}

/// Throws std::logic_error where the action is of another kind, or does not have that many numbers.
void check_kind(const Action& action, Kind kind, std::size_t count);

/// Returns the action's numbers by name: numbers_of<numbers::collide>(action).clear. Throws std::logic_error where the
/// action is of another kind, or does not have as many numbers.
template <template <class> class Numbers, class T = double>
Numbers<T> numbers_of(const Action& action) {
  check_kind(action, Numbers<T>::kKind, sizeof(Numbers<T>) / sizeof(T));
  return read_numbers<Numbers, T>(action.numbers.data());
}

template <class Visitor>
constexpr void fields(Visitor& visit, Action& action) {
  visit(action.kind, action.numbers, action.shapes, action.where, action.target, action.values, action.other,
        action.second, action.ties, action.table, action.leaves, action.results);
}

/// The most spheres of a clump.
inline constexpr std::size_t kMostSpheres = 64;

/// Tells whether particles meet as grains: spheres, or clumps of them.
inline bool is_contact(const Action& action) {
  return action.kind == Kind::contact || action.kind == Kind::contact_clumps;
}
/// What both have: their first numbers are the same.
numbers::contact<double> contact_of(const Action& action);

/// What the recorder, the checks and the compiler of programs need to know about a kind. Attributes are bit masks of
/// particles::Builtin indices.
struct Facts {
  const char* name = "";
  std::vector<Number> numbers{};
  int shapes = 0;
  std::uint32_t reads = 0;
  std::uint32_t writes = 0;
  bool needs_surface = false;  // its shape must have a surface that a particle can meet
  int ramp = 0;  // the numbers are knots, as many as given: age / lifetime, then this many numbers of the value
  int table = 0;  // it has a table, whose entries have this many numbers
  bool draws = false;  // its last shape is only drawn from
  const char* call = nullptr;  // what a script calls, where that is not the name
  bool between = false;  // between particles: a law, which has no kernel over a block
};

const Facts& facts(Kind kind);

/// The name of what a script calls to record the kind, for messages.
std::string call_of(Kind kind);

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

/// How many numbers a pair of `interact` remembers.
int states_of(const Action& action);

/// Whether it is a particle of the system that has the action in its list whose attribute a leaf is: where two systems
/// meet, both lists have it.
bool reads_here(const Action& action, const Leaf& leaf);

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
