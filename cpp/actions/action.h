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

/// A column that expressions of `interact` read: a component of one of the two particles, or of a quantity of the pair.
struct Leaf {
  enum class Of : std::uint8_t { own, other, distance, normal, state };
  Of of = Of::own;
  std::int32_t attribute = 0;  // own, other
  std::int32_t component = 0;  // index into the attribute, the normal or the states

  bool operator==(const Leaf&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Leaf& leaf) {
  visit(leaf.of, leaf.attribute, leaf.component);
}

/// Where a value of `law` or `interact` goes.
struct Result {
  enum class How : std::uint8_t { rate, change, value, state };
  How how = How::rate;  // rate: adds value * dt; change: adds value; value: replaces the attribute; state: of the pair
  std::int32_t attribute = 0;
  std::int32_t component = 0;  // of the attribute or the state

  bool operator==(const Result&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Result& result) {
  visit(result.how, result.attribute, result.component);
}

/// How `contact` treats one of its walls.
struct WallNumbers {
  double stiffness = 0;  // N/m
  double restitution = 0, friction = 0, rolling_friction = 0;

  bool operator==(const WallNumbers&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, WallNumbers& wall) {
  visit(wall.stiffness, wall.restitution, wall.friction, wall.rolling_friction);
}

/// A recorded action. `numbers` are in the order of the kind's struct in actions::numbers, or the knots of its ramp.
struct Action {
  Kind kind = Kind::move;
  std::vector<double> numbers;
  std::vector<shapes::Shape> shapes;  // the action's own, then those in its expressions
  Expression where{};  // a condition; empty: all particles
  std::int32_t target = -1;  // set: the attribute
  std::vector<Expression> values{};  // set: one per component; law, interact: one per result
  std::int32_t other = -1;  // interactions between two systems: the other system; else -1
  bool second = false;  // whether this is the entry in the other system's list
  std::uint64_t ties = 0;  // tie: the key of the ties
  TableKey table = 0;  // field, follow_path, contact_clumps: the key of their table
  std::vector<Leaf> leaves{};  // interact: the columns that its values read
  std::vector<Result> results{};  // law, interact
  std::vector<WallNumbers> walls{};  // contact: its walls, which are the first of its shapes

  bool operator==(const Action&) const = default;
};

/// Returns an action with these numbers, whose type gives its kind.
template <template <class> class Numbers>
Action make(const Numbers<double>& numbers, std::vector<shapes::Shape> shapes = {}) {
  Action action{Numbers<double>::kKind, {}, std::move(shapes)};
  if constexpr (!std::is_empty_v<Numbers<double>>) {
    const auto values = std::bit_cast<std::array<double, sizeof numbers / sizeof(double)>>(numbers);
    action.numbers.assign(values.begin(), values.end());
  }
  return action;
}

/// Throws std::logic_error if the action is not of this kind or does not have `count` numbers.
void check_kind(const Action& action, Kind kind, std::size_t count);

/// Returns the action's numbers as a struct: numbers_of<numbers::collide>(action).clear. Throws std::logic_error if the
/// action is of another kind or has a different count of numbers.
template <template <class> class Numbers, class T = double>
Numbers<T> numbers_of(const Action& action) {
  check_kind(action, Numbers<T>::kKind, sizeof(Numbers<T>) / sizeof(T));
  return read_numbers<Numbers, T>(action.numbers.data());
}

template <class Visitor>
constexpr void fields(Visitor& visit, Action& action) {
  visit(action.kind, action.numbers, action.shapes, action.where, action.target, action.values, action.other,
        action.second, action.ties, action.table, action.leaves, action.results, action.walls);
}

/// The maximum number of walls in a contact.
inline constexpr std::size_t kMostWalls = 65536;

/// The maximum number of spheres in a clump.
inline constexpr std::size_t kMostSpheres = 64;

/// Returns whether the action is a contact of grains: spheres, or clumps of spheres.
inline bool is_contact(const Action& action) {
  return action.kind == Kind::contact || action.kind == Kind::contact_clumps;
}
/// Returns the numbers that both kinds of contact share: the first ones of each.
numbers::contact<double> contact_of(const Action& action);

/// Properties of a kind of action, for the recorder, the checks and the program compiler. Attributes are bit masks of
/// particles::Builtin indices.
struct Facts {
  const char* name = "";
  std::vector<Number> numbers{};
  int shapes = 0;
  std::uint32_t reads = 0;
  std::uint32_t writes = 0;
  bool needs_surface = false;  // its shape must have a surface that a particle can meet
  int ramp = 0;  // above 0: `numbers` are knots, each age / lifetime and a value of `ramp` components
  int table = 0;  // above 0: the action reads a table whose entries have this many numbers
  bool draws = false;  // its last shape is only sampled
  const char* call = nullptr;  // the function that scripts call, if its name differs
  bool between = false;  // an interaction between particles, without a kernel over blocks
};

const Facts& facts(Kind kind);

/// Returns the name of the function that records the kind in scripts, for messages.
std::string call_of(Kind kind);

/// Returns the kind with this name. Throws std::invalid_argument if there is none.
Kind kind_of(const std::string& name);

/// Return the attributes that the action reads or writes in a system of this schema, one bit each. `reads` includes
/// those of its expressions.
std::uint64_t reads(const Action& action, const particles::Schema& schema);
std::uint64_t writes(const Action& action, const particles::Schema& schema);
/// Returns only the attributes that the action's expressions read.
std::uint64_t named(const Action& action, const particles::Schema& schema);

/// Returns the attributes that an expression reads, one bit each.
std::uint64_t columns_of(const Expression& expression, const particles::Schema& schema);

/// Returns how many numbers `interact` keeps per pair; 0 for other kinds.
int states_of(const Action& action);

/// Returns whether a leaf is an attribute of the system whose list holds this action. An interaction between two
/// systems is in both lists.
bool reads_here(const Action& action, const Leaf& leaf);

/// Return whether the action or the expression uses a *_b attribute.
bool uses_copies(const Action& action, const particles::Schema& schema);
bool uses_copies(const Expression& expression, const particles::Schema& schema);

/// Checks the action. Throws std::invalid_argument naming the argument, its value and what is allowed.
void check(const Action& action);
/// Checks the action's expressions, whose columns are those of `schema`. Throws std::invalid_argument.
void check(const Action& action, const particles::Schema& schema);

/// Checks a condition; an empty one means none. Throws std::invalid_argument.
void check_condition(const Expression& where, const std::vector<shapes::Shape>& shapes,
                     const particles::Schema& schema);

}  // namespace motes::actions
