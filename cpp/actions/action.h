// An action over particles as a plain value (paper 3.1.5), and the facts about each kind of action.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "actions/numbers.h"
#include "actions/specifics.h"
#include "expressions/expression.h"
#include "particles/schema.h"
#include "shapes/shape.h"

namespace motes::actions {

using expressions::Instruction;
using expressions::Op;

/// The other system of an interaction between two, which is in the lists of both.
struct Partner {
  std::int32_t system = 0;
  bool second = false;  // whether this is the entry in the second system's list

  bool operator==(const Partner&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Partner& partner) {
  visit(partner.system, partner.second);
}

/// A recorded action. `numbers` are in the order of the kind's struct in actions::numbers, or the knots of its ramp.
struct Action {
  Kind kind = Kind::move;
  std::vector<double> numbers;
  std::vector<shapes::Shape> shapes;  // the action's own, then those in its expressions
  Expression where{};                 // a condition; empty: all particles
  Specifics specifics{};
  std::optional<Partner> partner{};

  bool second() const { return partner && partner->second; }

  bool operator==(const Action&) const = default;
};

/// Returns the specifics of a kind, empty.
const Specifics& specifics_of(Kind kind);

/// Returns an action with these numbers, whose type gives its kind.
template <template <class> class Numbers>
Action make(const Numbers<double>& numbers, std::vector<shapes::Shape> shapes = {}) {
  Action action{Numbers<double>::kKind, {}, std::move(shapes), {}, specifics_of(Numbers<double>::kKind)};
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
  visit(action.kind, action.numbers, action.shapes, action.where, action.specifics, action.partner);
}

/// Returns the specifics of a contact of grains; null for other kinds.
inline const Grains* grains_of(const Action& action) { return std::get_if<Grains>(&action.specifics); }
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
  Specifics specifics{};  // of this alternative
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
std::uint64_t writes(const Action& action);
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
