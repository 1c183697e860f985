// Secondary births: events in the lives of some particles make others.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "actions/expression.h"
#include "particles/store.h"
#include "recording/births.h"

namespace motes::recording {

/// A rule for one frame: each event makes `count` particles of system `into`, at the frame's end, where the parent is
/// then. A particle counts once per rule and frame.
struct Spawn {
  enum class On : std::uint8_t { birth, death, collision };
  std::int32_t into = 0;  // a system's index
  On on = On::death;
  std::uint32_t count = 1;
  double inherit_velocity = 0;         // part of the parent's velocity that is added to the children's own
  std::vector<Given> state;            // what the children get otherwise
  actions::Expression where;           // which parents; empty: all
  std::vector<shapes::Shape> shapes;   // that `where` names

  bool operator==(const Spawn&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Spawn& spawn) {
  visit(spawn.into, spawn.on, spawn.count, spawn.inherit_velocity, spawn.state, spawn.where, spawn.shapes);
}

/// What is known of a parent.
struct Event {
  std::uint64_t id = 0;
  float position[3] = {};
  float velocity[3] = {};
};

template <class Visitor>
constexpr void fields(Visitor& visit, Event& event) {
  visit(event.id, event.position, event.velocity);
}

/// A child that an event makes. The event must outlive it.
struct Child {
  std::uint64_t id = 0;
  const Event* event = nullptr;
};

/// Throws std::invalid_argument, naming argument, value and what is allowed.
void check(const Spawn& spawn, const particles::Schema& parents, const particles::Schema& children);

/// Of the particles at these indices (ascending), those for which `where` holds, as events in the order of ids.
std::vector<Event> events_of(const Spawn& spawn, const particles::Store& parents,
                             const std::vector<std::uint32_t>& indices);

/// Makes children where their parents are, with the rule's state and its part of the parent's velocity.
particles::Store make(const Spawn& rule, const std::vector<Child>& children, const particles::Schema& schema,
                      particles::Key key, bool keeps_copies);

}  // namespace motes::recording
