// The part of a particle system that every rank knows: definition, domains, counts, and this frame's list. The
// particles are in a Population.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "domains/domains.h"
#include "engine/state/birth_history.h"
#include "particles/digest.h"
#include "particles/schema.h"
#include "program/program.h"
#include "recording/record.h"
#include "recording/source_total.h"

namespace motes::engine {

/// The particles that one call creates in one sub-step. All ranks count the same groups.
struct BirthGroup {
  std::size_t item = 0;  // index of the call in the list
  std::size_t entry = 0;  // number of pending actions before the call; newborns skip them
  int substep = 0;
  std::uint64_t first_id = 0;
  std::uint64_t count = 0;
};

/// A part of the list without callbacks or pair interactions inside.
struct ListSegment {
  program::Program program;
  std::size_t first = 0;  // number of pending actions before it
  std::size_t end = 0;  // index of the list item that follows it, or the list's length
  const recording::Callback* callback = nullptr;  // callback that follows in the list, if any
  const actions::Action* interaction = nullptr;  // pair interaction that follows in the list, if any
};

/// Particle counts that all ranks agree on.
struct Counts {
  std::uint64_t alive = 0;  // at the end of the last frame
  std::uint64_t alive_at_start = 0;  // when this frame began; counted against the capacity
  std::uint64_t born = 0;  // number of ids assigned so far
  std::uint64_t born_at_start = 0;  // births before this frame
  std::uint64_t newborn_from = 0;  // first id of this frame's births, as spawn rules count them
  std::uint64_t dropped = 0;  // births dropped so far because of the capacity
};

template <class Visitor>
constexpr void fields(Visitor& visit, Counts& counts) {
  visit(counts.alive, counts.alive_at_start, counts.born, counts.born_at_start, counts.newborn_from, counts.dropped);
}

/// What the script tells the engine about a system outside its lists; it holds until the script says otherwise.
struct Outside {
  image::Sprite sprite;
  actions::TableKey clumps = 0;  // the template, if particles are clumps
};

class System {
 public:
  System(recording::SystemDefinition definition, std::uint64_t seed, std::uint32_t index, int calculators);

  /// Counts and numbers the births of the pending items, by time and then list order, into `groups`. Births beyond the
  /// capacity are dropped and counted.
  void count_births(double dt, int substeps);

  /// Returns the id of the first particle that a burst or emit recorded now would create, and how many more the
  /// capacity allows.
  std::pair<std::uint64_t, std::uint64_t> next_birth(double dt, int substeps) const;

  /// Creates particles first .. first + count - 1 of a group.
  particles::Store make(const BirthGroup& group, std::uint64_t first, std::uint64_t count, double dt,
                        int substeps) const;
  /// Creates the particles of a group with these numbers.
  particles::Store make(const BirthGroup& group, std::span<const std::uint32_t> numbers, double dt, int substeps) const;

  /// Returns the actions of the pending items, split at callbacks and pair interactions; at least one segment.
  std::vector<ListSegment> pending_segments() const;

  /// Returns whether the pending items contain pair interactions.
  bool interacts() const;

  /// Returns the frame's spawn rules so far, in order.
  std::vector<const recording::Spawn*> rules() const;

  /// Returns the actions of kind `sort` from item `first` on.
  std::vector<const actions::Action*> sorts(std::size_t first) const;

  /// Returns the magnitude of the sum of the `gravity` actions before item `end` of the list, m/s2.
  double gravity(std::size_t end) const;

  /// Marks all items so far as run.
  void mark_run() { run_items = list.size(); }
  bool pending() const { return run_items < list.size(); }

  /// Assigns ids to this frame's children, to as many of `spawned` as the capacity allows; returns how many.
  std::uint64_t number_children(std::uint64_t spawned);
  void start_frame();

  /// Makes meshes with new vertices among the walls of an action that is about to be recorded deform from the vertices
  /// and places of the last frame: the n-th wall of a mesh from the n-th of that frame.
  void sweep(actions::Action& action);

  /// Returns how many more particles the capacity allows after `taken`.
  std::uint64_t room_of(std::uint64_t taken) const {
    return definition.capacity > taken ? definition.capacity - taken : 0;
  }

  recording::SystemDefinition definition;
  particles::Schema schema;
  particles::Key key;
  Outside outside;
  domains::Domains domains;
  bool waits_for_fit = false;  // space is "fit", and there was no birth yet
  bool keeps_copies = false;  // the *_b attributes are in use: newborns store their values at birth
  BirthHistory history;  // until `keeps_copies`
  bool asks_oldest = false;  // the history has grown: reports include the lowest live id
  Counts counts;
  std::vector<recording::SourceTotal> sources;  // total of each source so far
  particles::Digest digest;  // digest of all particles, from the last verdict

  // Meshes that this frame's list has as walls, in order; those of the last frame.
  std::vector<shapes::Shape> walls, walls_before;

  std::vector<recording::Item> list;  // this frame's list
  std::size_t run_items = 0;  // number of items that have run; later ones are pending
  std::vector<BirthGroup> groups;  // births of the pending items, by id

 private:
  particles::Store make(const BirthGroup& group, const std::vector<std::uint64_t>& ids, double dt, int substeps) const;
};

/// Returns whether one of the system's spawn rules applies to this event.
bool asks_for(const System& system, recording::Spawn::On event);

}  // namespace motes::engine
