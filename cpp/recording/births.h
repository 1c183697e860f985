// Births as the script recorded them (paper 3.2.1), and how many particles they create.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "actions/kernels.h"
#include "particles/schema.h"
#include "particles/store.h"
#include "shapes/shape.h"

namespace motes::recording {

/// What newborn particles get in one attribute.
struct Given {
  int attribute = 0;
  actions::Distribution distribution;

  bool operator==(const Given&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Given& given) {
  visit(given.attribute, given.distribution);
}

/// One column of an emit() call: count * width floats, particle by particle.
struct Emitted {
  int attribute = 0;
  std::vector<float> values;

  bool operator==(const Emitted&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Emitted& emitted) {
  visit(emitted.attribute, emitted.values);
}

struct Birth {
  enum class Kind : std::uint8_t { source, burst, emit };
  Kind kind = Kind::burst;
  shapes::Shape shape;           // source, burst: where
  double rate = 0;               // source: particles per second
  std::uint64_t amount = 0;      // burst, emit: particles
  bool jitter = false;           // source: spread over the step
  std::vector<Given> state;      // the source state (API: System.configure) when the call was recorded
  std::vector<Emitted> columns;  // emit: the arrays, each of `amount` particles

  bool operator==(const Birth&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Birth& birth) {
  visit(birth.kind, birth.shape, birth.rate, birth.amount, birth.jitter, birth.state, birth.columns);
}

/// Throws std::invalid_argument, naming argument, value and what is allowed.
void check(const Birth& birth, const particles::Schema& schema);

/// How many particles the call creates in the step from time `from` to time `to` (seconds since the run's start): a
/// source floor(rate to) - floor(rate from), where a product that is an integer up to rounding counts as that integer;
/// a burst, vertex or emit the number that it was given.
std::uint64_t births_between(const Birth& birth, double from, double to);

/// Creates particles first_id .. first_id + count - 1 of the call: they depend only on the arguments, so any rank may
/// create them. dt: the step's length in seconds, for jitter. keeps_copies: the system uses the *_b attributes, so
/// newborns without a value for them get copies. skip: how many particles of the call before first_id are created
/// elsewhere; the rows of an emit start after theirs.
particles::Store make(const Birth& birth, const particles::Schema& schema, particles::Key key, std::uint64_t first_id,
                      std::uint64_t count, float dt, bool keeps_copies = false, std::uint64_t skip = 0);
/// The same with ids in any order.
particles::Store make(const Birth& birth, const particles::Schema& schema, particles::Key key,
                      std::span<const std::uint64_t> ids, float dt, bool keeps_copies = false, std::uint64_t skip = 0);

/// Whether the call gives newborns a *_b attribute.
bool gives_copies(const Birth& birth);

}  // namespace motes::recording
