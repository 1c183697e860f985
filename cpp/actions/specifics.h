// What actions of some kinds have beside numbers and shapes: a struct per family, with its bytes and its checks. Which
// one a kind has is a fact in list.inc.
#pragma once

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "actions/tables.h"
#include "expressions/expression.h"
#include "particles/schema.h"

namespace motes::actions {

using expressions::Expression;

struct Action;

struct NumbersAlone {
  bool operator==(const NumbersAlone&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor&, NumbersAlone&) {}

/// What `set` does: an attribute becomes the values of expressions.
struct Assignment {
  std::int32_t attribute = -1;
  std::vector<Expression> values;  // one per component

  void check(const Action& action, const particles::Schema& schema) const;
  bool operator==(const Assignment&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Assignment& set) {
  visit(set.attribute, set.values);
}

/// Actions whose numbers differ from particle to particle: an expression for each number of the kind with this call.
struct PerParticle {
  std::vector<Expression> values;

  void check(const Action& action, const particles::Schema& schema) const;
  bool operator==(const PerParticle&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, PerParticle& per) {
  visit(per.values);
}

/// Where a value of a script's law goes.
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

/// A law of a script: expressions of one particle's columns change it.
struct ParticleLaw {
  std::vector<Expression> values;  // one per result
  std::vector<Result> results;

  void check(const Action& action, const particles::Schema& schema) const;
  bool operator==(const ParticleLaw&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, ParticleLaw& law) {
  visit(law.values, law.results);
}

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

/// What `interact` does: expressions of two particles' columns change the first of them.
struct PairLaw {
  std::vector<Leaf> leaves;  // the columns that the values read
  std::vector<Expression> values;  // one per result
  std::vector<Result> results;

  void check(const Action& action, const particles::Schema& schema) const;
  bool operator==(const PairLaw&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, PairLaw& law) {
  visit(law.leaves, law.values, law.results);
}

/// Which particles are tied. The ties themselves are kept by interactions/ties.h.
struct TiedPairs {
  std::uint64_t ties = 0;  // their key

  bool operator==(const TiedPairs&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, TiedPairs& tied) {
  visit(tied.ties);
}

/// Actions that look up a table of Facts::table numbers per entry.
struct Lookup {
  TableKey table = 0;

  void check(const Action& action) const;
  bool operator==(const Lookup&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Lookup& lookup) {
  visit(lookup.table);
}

/// How grains touch one of their walls.
struct WallNumbers {
  double stiffness = 0;  // N/m
  double restitution = 0, friction = 0, rolling_friction = 0;

  bool operator==(const WallNumbers&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, WallNumbers& wall) {
  visit(wall.stiffness, wall.restitution, wall.friction, wall.rolling_friction);
}

/// The maximum number of walls in a contact.
inline constexpr std::size_t kMostWalls = 65536;

/// The maximum number of spheres in a clump.
inline constexpr std::size_t kMostSpheres = 64;

/// A contact of grains, which are spheres or clumps of spheres.
struct Grains {
  std::vector<WallNumbers> walls;  // the first of the action's shapes
  TableKey clump = 0;  // the template: x, y, z and radius of each sphere; 0: grains are spheres

  void check(const Action& action) const;
  bool operator==(const Grains&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Grains& grains) {
  visit(grains.walls, grains.clump);
}

using Specifics = std::variant<NumbersAlone, Assignment, ParticleLaw, PairLaw, TiedPairs, Lookup, Grains, PerParticle>;

}  // namespace motes::actions
