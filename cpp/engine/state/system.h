// A particle system as every rank knows it: definition, domains, counts, and this frame's list. Its particles are in a
// Population.
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

/// Particles that one call makes in one (sub)step. Every rank counts the same groups.
struct BirthGroup {
  std::size_t item = 0;  // place in the list
  std::size_t entry = 0;  // actions before it in its segment: newborns start behind them
  int substep = 0;
  std::uint64_t first_id = 0;
  std::uint64_t count = 0;
};

/// A stretch of the list between callbacks and pair interactions.
struct ListSegment {
  program::Program program;
  std::size_t first = 0;  // actions before it in the segment
  std::size_t end = 0;  // place in the list of what stands behind it, or the list's length
  const recording::Callback* callback = nullptr;  // callback that follows in the list, if any
  const actions::Action* interaction = nullptr;  // pair interaction that follows in the list, if any
};

/// Numbers of particles that all ranks agree on.
struct Counts {
  std::uint64_t alive = 0;  // at the end of the last frame
  std::uint64_t alive_at_start = 0;  // particles alive when this frame began; counted against the capacity
  std::uint64_t born = 0;  // ids given so far
  std::uint64_t born_at_start = 0;  // births before this frame
  std::uint64_t newborn_from = 0;  // ids from here on are new in this frame: they count as births for spawn rules
  std::uint64_t dropped = 0;  // births above the capacity so far
};

template <class Visitor>
constexpr void fields(Visitor& visit, Counts& counts) {
  visit(counts.alive, counts.alive_at_start, counts.born, counts.born_at_start, counts.newborn_from, counts.dropped);
}

class System {
 public:
  System(recording::SystemDefinition definition, std::uint64_t seed, std::uint32_t index, int calculators);

  /// Counts the births of the items recorded since the last run and numbers them: in time order, then list order.
  /// Births beyond the capacity are dropped and counted. The result stands in `groups`, in the order of ids.
  void count_births(double dt, int substeps);

  /// The id of the first particle that a burst or emit would make here, and how many the capacity has room for then.
  std::pair<std::uint64_t, std::uint64_t> next_birth(double dt, int substeps) const;

  /// Makes `count` of a group's particles, from its number `first` on.
  particles::Store make(const BirthGroup& group, std::uint64_t first, std::uint64_t count, double dt,
                        int substeps) const;
  /// Makes those with these numbers.
  particles::Store make(const BirthGroup& group, std::span<const std::uint32_t> numbers, double dt, int substeps) const;

  /// Actions of the items that have not run yet, cut where callbacks stand. One segment at least.
  std::vector<ListSegment> pending_segments() const;

  /// Tells whether the items that have not run yet contain pair interactions.
  bool interacts() const;

  /// The frame's spawn rules so far, in order.
  std::vector<const recording::Spawn*> rules() const;

  /// The actions of kind `sort` from item `first` on.
  std::vector<const actions::Action*> sorts(std::size_t first) const;

  /// Marks all items so far as run.
  void mark_run() { run_items = list.size(); }
  bool pending() const { return run_items < list.size(); }

  /// Gives numbers to this frame's children, as many of `spawned` as the capacity allows; returns how many.
  std::uint64_t number_children(std::uint64_t spawned);
  void start_frame();

  /// Returns how many more particles fit if there are `taken`.
  std::uint64_t room_of(std::uint64_t taken) const {
    return definition.capacity > taken ? definition.capacity - taken : 0;
  }

  recording::SystemDefinition definition;
  particles::Schema schema;
  particles::Key key;
  image::Sprite sprite;
  actions::TableKey clumps = 0;  // the template, where particles are clumps
  domains::Domains domains;
  bool waits_for_fit = false;  // space "fit", and no birth yet
  bool keeps_copies = false;  // the *_b attributes are in use: newborns get copies of what they are at birth
  BirthHistory history;  // until copies are kept
  bool asks_oldest = false;  // the history has grown: reports say which ids still live
  Counts counts;
  std::vector<recording::SourceTotal> sources;  // total of each source so far
  particles::Digest digest;  // digest of all particles, as last agreed

  std::vector<recording::Item> list;  // this frame's
  std::size_t run_items = 0;  // number of items that have run
  std::vector<BirthGroup> groups;  // births of those that have not

 private:
  particles::Store make(const BirthGroup& group, const std::vector<std::uint64_t>& ids, double dt, int substeps) const;
};

/// Tells whether a spawn rule needs the particles of this event.
bool asks_for(const System& system, recording::Spawn::On event);

}  // namespace motes::engine
