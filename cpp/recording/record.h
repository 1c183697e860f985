// What a script recorded in a frame: one plain value that serialises to bytes. All ranks compare its hash; written to a
// file it can be replayed without Python.
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
  std::uint64_t capacity = UINT64_MAX;  // most particles alive at once
  domains::Axes axes;  // that domains cut
  domains::Space space;
  std::int32_t domains_of = -1;  // the earlier system whose domains it shares; -1: it has its own
  image::Sprite sprite;
  std::vector<UserAttribute> attributes;
  particles::Periods periods;  // of the world, the same for all of its systems

  bool operator==(const SystemDefinition&) const = default;
};

/// The columns and the space of its particles. Throws std::invalid_argument where it cannot have them.
particles::Schema schema_of(const SystemDefinition& system);

template <class Visitor>
constexpr void fields(Visitor& visit, SystemDefinition& system) {
  visit(system.name, system.capacity, system.axes, system.space, system.domains_of, system.sprite, system.attributes,
        system.periods);
}

/// The script read or wrote particles here: items before this one run before those after it.
struct Read {
  bool operator==(const Read&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor&, Read&) {}

/// A function of the script that acts on each particle alone. It is stored by name and is the only item that needs
/// Python to replay.
struct Callback {
  std::string name;
  std::int32_t number = 0;  // index among the callbacks of its system in this frame
  actions::Expression where{};  // a truth value; empty: all particles
  std::vector<shapes::Shape> shapes{};  // those that `where` uses

  bool operator==(const Callback&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Callback& callback) {
  visit(callback.name, callback.number, callback.where, callback.shapes);
}

/// Something outside of the lists has named a *_b attribute: it is in use from here on.
struct KeepCopies {
  bool operator==(const KeepCopies&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor&, KeepCopies&) {}

using Item = std::variant<Birth, actions::Action, Read, Spawn, Callback, KeepCopies>;

/// What all ranks were asked to do.
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
  orders
};
std::string name(Verb verb);
/// What a script calls it: "gravity", "burst", "callback NAME", ...
std::string name(const Item& item);
/// Whether a call of the script has recorded it, rather than something that the script read.
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
  std::vector<actions::TableKey> clumps;  // one per system: the template of its clumps; 0: its particles are none
  std::optional<image::View> view;  // verb render
  std::string
      argument;  // what a verb is asked for: of gather, the system and the destination; of a frame, the controls

  bool operator==(const Record&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Record& record) {
  visit(record.verb, record.frame, record.seed, record.dt, record.substeps, record.systems, record.lists,
        record.sprites, record.clumps, record.view, record.argument);
}

void write(const Record& record, base::Bytes& out);
/// Throws std::runtime_error where the bytes are not a record.
Record read(base::Reader& in);

/// Throws std::invalid_argument where a sprite is invalid, or its pick for particles of a schema.
void check(const image::Sprite& sprite, const particles::Schema& schema);

/// One sentence about the first thing in which two records differ.
std::string first_difference(const Record& ours, const Record& theirs);

}  // namespace motes::recording
