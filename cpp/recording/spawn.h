// Secondary births: events in the lives of some particles create others.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "actions/action.h"
#include "particles/store.h"
#include "recording/births.h"

namespace motes::recording {

/// A rule for one frame: each event creates `count` particles of system `into` at the end of the frame, at the parent's
/// position at that time. A particle counts once per rule and frame.
struct Spawn {
  enum class On : std::uint8_t { birth, death, collision, frame };  // frame: the particle is alive at its end
  std::int32_t into = 0;  // a system's index
  On on = On::death;
  std::uint32_t count = 1;
  double inherit_velocity = 0;         // fraction of the parent's velocity that is added to the children's own
  std::vector<Given> state;            // the other attributes of the children
  actions::Expression where;           // which parents; empty: all
  std::vector<shapes::Shape> shapes;   // those that `where` uses

  bool operator==(const Spawn&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Spawn& spawn) {
  visit(spawn.into, spawn.on, spawn.count, spawn.inherit_velocity, spawn.state, spawn.where, spawn.shapes);
}

/// A parent at the time of the event.
struct Event {
  std::uint64_t id = 0;
  float position[3] = {};
  float velocity[3] = {};
};

template <class Visitor>
constexpr void fields(Visitor& visit, Event& event) {
  visit(event.id, event.position, event.velocity);
}

/// A child that an event creates. The event must outlive it.
struct Child {
  std::uint64_t id = 0;
  const Event* event = nullptr;
};

/// Checks a rule. Throws std::invalid_argument naming the argument, its value and what is allowed.
void check(const Spawn& spawn, const particles::Schema& parents, const particles::Schema& children);

/// Creates children at their parents' positions, with the rule's state and the inherited fraction of the parent's
/// velocity.
particles::Store make(const Spawn& rule, const std::vector<Child>& children, const particles::Schema& schema,
                      particles::Key key, bool keeps_copies);

}  // namespace motes::recording
