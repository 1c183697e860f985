// Births as the script recorded them (paper 3.2.1), and the particles that they create.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "actions/kernels.h"
#include "particles/schema.h"
#include "particles/store.h"
#include "shapes/shape.h"

namespace motes::recording {

/// The values of one attribute of newborn particles.
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

/// A source: particles that appear in a shape throughout the frame.
struct Source {
  shapes::Shape shape;  // where
  std::vector<shapes::Shape> before;  // the shape when the frame began; empty: it does not move
  double rate = 0;  // particles per second; 0 if it changes within the frame
  // Of a rate that changes: its integral since some fixed time, in particles, at the start of the frame and at the end
  // of each sub-step.
  std::vector<double> integral;
  double scale = 0;  // particles; rounding errors of the integral are relative to this, if it is larger
  std::uint64_t number = 0;  // tells a system's sources apart (recording/source_total.h)
  bool jitter = false;  // births are spread over the step
  std::vector<Given> state;  // the source state (API: System.configure) when the call was recorded

  bool operator==(const Source&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Source& source) {
  visit(source.shape, source.before, source.rate, source.integral, source.scale, source.number, source.jitter,
        source.state);
}

/// A burst: particles that appear in a shape at once.
struct Burst {
  shapes::Shape shape;  // where
  std::uint64_t count = 0;
  std::vector<Given> state;  // as a source's

  bool operator==(const Burst&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Burst& burst) {
  visit(burst.shape, burst.count, burst.state);
}

/// An emit() call: particles given as arrays.
struct Emit {
  std::uint64_t count = 0;
  std::vector<Emitted> columns;  // the arrays, each of `count` particles
  std::vector<Given> state;  // as a source's; columns take precedence

  bool operator==(const Emit&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Emit& emit) {
  visit(emit.count, emit.columns, emit.state);
}

using Birth = std::variant<Source, Burst, Emit>;

/// Checks a birth. Throws std::invalid_argument naming argument, value and what is allowed.
void check(const Source& source, const particles::Schema& schema);
void check(const Burst& burst, const particles::Schema& schema);
void check(const Emit& emit, const particles::Schema& schema);
void check(const Birth& birth, const particles::Schema& schema);
/// Checks values of newborn particles. `shape`: where they are born; null: given as positions.
void check(const std::vector<Given>& state, const particles::Schema& schema, const shapes::Shape* shape);

/// Returns the values of its newborn particles that are not given as arrays.
inline const std::vector<Given>& state_of(const Birth& birth) {
  return std::visit([](const auto& kind) -> const std::vector<Given>& { return kind.state; }, birth);
}

/// Returns what a script calls it: "source", "burst" or "emit".
std::string name(const Birth& birth);

/// The (sub)step in which particles are born.
struct BirthStep {
  constexpr BirthStep(float seconds = 0) : dt(seconds) {}  // NOLINT(google-explicit-constructor): a whole frame
  constexpr BirthStep(float seconds, int substep, int substeps)
      : dt(seconds), start(static_cast<float>(substep) / static_cast<float>(substeps)),
        end(static_cast<float>(substep + 1) / static_cast<float>(substeps)) {}

  float dt;  // its length, seconds
  float start = 0, end = 1;  // the part of the frame that it covers, for moving shapes

  bool operator==(const BirthStep&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, BirthStep& moment) {
  visit(moment.dt, moment.start, moment.end);
}

/// Returns the moment of a call's births: the same in all sub-steps if its shape does not move.
BirthStep moment_of(const Birth& birth, float dt, int substep, int substeps);

/// Returns the meshes that its shapes are made of.
std::vector<std::uint64_t> meshes_of(const Birth& birth);

/// Creates particles first_id .. first_id + count - 1 of the call. They depend only on the arguments, so any rank may
/// create them. moment: the step, for jitter and moving shapes. keeps_copies: the system uses the *_b attributes, so
/// newborns without a value for them get copies. skip: how many particles of the call before first_id are created
/// elsewhere; the rows of an emit start after theirs.
particles::Store make(const Birth& birth, const particles::Schema& schema, particles::Key key, std::uint64_t first_id,
                      std::uint64_t count, const BirthStep& moment, bool keeps_copies = false, std::uint64_t skip = 0);
/// Creates particles with these ids, in any order. Row i of an emit belongs to id first_of_call + i or, without
/// first_of_call, to ids[i].
particles::Store make(const Birth& birth, const particles::Schema& schema, particles::Key key,
                      std::span<const std::uint64_t> ids, const BirthStep& moment, bool keeps_copies = false,
                      std::optional<std::uint64_t> first_of_call = std::nullopt);

/// Returns whether the call gives newborns a *_b attribute.
bool gives_copies(const Birth& birth);

}  // namespace motes::recording
