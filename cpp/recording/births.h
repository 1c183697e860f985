// Births as the script recorded them (paper 3.2.1), and how many particles they make.
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

/// How many particles the call makes in the step from time `from` to time `to` (seconds since the run's start):
/// a source floor(rate to) - floor(rate from), where a product that is a whole number up to rounding counts as that
/// number. A burst, vertex or emit makes its number.
std::uint64_t births_between(const Birth& birth, double from, double to);

/// Makes particles first_id .. first_id + count - 1 of the call: they depend on the arguments alone, so any rank may
/// make them. dt: the step's length in seconds, for jitter.
/// keeps_copies: the system uses the *_b attributes, so newborns that are not given them get copies.
/// skip: how many particles of the call are made elsewhere, before first_id; an emit's rows begin behind theirs.
particles::Store make(const Birth& birth, const particles::Schema& schema, particles::Key key, std::uint64_t first_id,
                      std::uint64_t count, float dt, bool keeps_copies = false, std::uint64_t skip = 0);
/// The same with ids of any order.
particles::Store make(const Birth& birth, const particles::Schema& schema, particles::Key key,
                      std::span<const std::uint64_t> ids, float dt, bool keeps_copies = false, std::uint64_t skip = 0);

/// Whether the call gives newborns a *_b attribute.
bool gives_copies(const Birth& birth);

}  // namespace motes::recording
