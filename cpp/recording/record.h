// What a script recorded in a frame: one plain value that serialises to bytes. All ranks compare its hash. Written to a
// file, it can be replayed without Python.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "actions/action.h"
#include "base/bytes.h"
#include "domains/domains.h"
#include "image/scene.h"
#include "recording/births.h"
#include "recording/spawn.h"

namespace motes::recording {

/// A user's own column (API: World.system, attributes).
struct UserAttribute {
  std::string name;
  int width = 1;
  particles::Value initial{};

  bool operator==(const UserAttribute&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, UserAttribute& attribute) {
  visit(attribute.name, attribute.width, attribute.initial);
}

/// A particle system as the script defined it.
struct SystemDefinition {
  std::string name;
  std::uint64_t capacity = UINT64_MAX;  // the maximum number of particles alive
  domains::Axes axes;  // the axes that domains cut
  domains::Space space;
  std::int32_t domains_of = -1;  // the earlier system whose domains it shares; -1: it has its own
  image::Sprite sprite;
  std::vector<UserAttribute> attributes;
  particles::Periods periods;  // of the world, the same for all of its systems

  bool operator==(const SystemDefinition&) const = default;
};

/// Returns the columns and the space of the system's particles. Throws std::invalid_argument if they are invalid.
particles::Schema schema_of(const SystemDefinition& system);

template <class Visitor>
constexpr void fields(Visitor& visit, SystemDefinition& system) {
  visit(system.name, system.capacity, system.axes, system.space, system.domains_of, system.sprite, system.attributes,
        system.periods);
}

/// Marks where the script read or wrote particles: items before it run before those after it.
struct Read {
  bool operator==(const Read&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor&, Read&) {}

/// A function of the script that acts on each particle independently. It is stored by name and is the only item that
/// needs Python to replay.
struct Callback {
  std::string name;
  std::int32_t number = 0;  // index among the callbacks of its system in this frame
  actions::Expression where{};  // a condition; empty: all particles
  std::vector<shapes::Shape> shapes{};  // those that `where` uses

  bool operator==(const Callback&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Callback& callback) {
  visit(callback.name, callback.number, callback.where, callback.shapes);
}

/// Marks where something outside the lists named a *_b attribute, which is in use from here on.
struct KeepCopies {
  bool operator==(const KeepCopies&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor&, KeepCopies&) {}

using Item = std::variant<Birth, actions::Action, Read, Spawn, Callback, KeepCopies>;

/// What all ranks are asked to do.
enum class Verb : std::uint8_t {
  start,
  render,
  step,
  digest,
  gather,
  total,
  histogram,
  tally,
  write,
  finish,
  redraw,
  orders,
  surface
};
std::string name(Verb verb);
/// Returns what a script calls an item: "gravity", "burst", "callback NAME", ...
std::string name(const Item& item);
/// Returns whether a call of the script recorded the item, rather than something that the script read.
bool is_call(const Item& item);

/// One frame's list.
struct Record {
  Verb verb = Verb::step;
  std::uint64_t frame = 0;
  std::uint64_t seed = 0;
  double dt = 0;
  int substeps = 1;
  std::vector<SystemDefinition> systems;  // all systems of the world so far
  std::vector<std::vector<Item>> lists;  // one per system
  std::vector<image::Sprite> sprites;  // one per system
  std::vector<actions::TableKey> clumps;  // one per system: the template of its clumps; 0: it has no clumps
  std::optional<image::View> view;  // verb render
  std::optional<image::Camera> camera;  // verb step: where the next picture's streaks begin
  std::string argument;  // of gather: the system and the destination; of a frame: the controls

  bool operator==(const Record&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Record& record) {
  visit(record.verb, record.frame, record.seed, record.dt, record.substeps, record.systems, record.lists,
        record.sprites, record.clumps, record.view, record.camera, record.argument);
}

void write(const Record& record, base::Bytes& out);
/// Reads a record. Throws std::runtime_error if the bytes are not a record.
Record read(base::Reader& in);

/// Throws std::invalid_argument if a sprite, or its pick for particles of a schema, is invalid.
void check(const image::Sprite& sprite, const particles::Schema& schema);

/// Returns a sentence about the first difference between two records.
std::string first_difference(const Record& ours, const Record& theirs);

}  // namespace motes::recording
