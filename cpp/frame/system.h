// One particle system on one rank: its definition, its domains, this rank's particles, what the script recorded.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "balance/policy.h"
#include "domains/domains.h"
#include "frame/birth_history.h"
#include "frame/report.h"
#include "particles/schema.h"
#include "particles/store.h"
#include "recording/program.h"
#include "recording/record.h"

namespace motes::frame {

/// Particles that one call makes in one (sub)step. Every rank counts the same groups.
struct BirthGroup {
  std::size_t item = 0;        // place in the list
  std::size_t entry = 0;       // actions before it in its segment: newborns start behind them
  int substep = 0;
  std::uint64_t first_id = 0;
  std::uint64_t count = 0;
};

/// A stretch of the list between callbacks.
struct Piece {
  recording::Program program;
  std::size_t first = 0;   // actions before it in the segment
  const recording::Callback* callback = nullptr;  // that stands behind it, if any; in the list
};

/// What happened to one system on one calculator in this frame.
struct Tally {
  std::uint64_t at_start = 0;
  std::uint64_t created = 0;
  std::uint64_t killed = 0;
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t bytes_sent = 0;
  double compute_s = 0;
};

class System {
 public:
  System(recording::SystemDefinition definition, std::uint64_t seed, std::uint32_t index, int calculators);

  /// The groups of the items recorded since the last run, in the order of their ids: a birth is counted in time
  /// order, then list order. Births beyond the capacity are dropped and counted.
  std::vector<BirthGroup> count_births(std::uint64_t frame, double dt, int substeps);

  /// Makes `count` of a group's particles, from its number `first` on.
  particles::Store make(const BirthGroup& group, std::uint64_t first, std::uint64_t count, double dt,
                        int substeps) const;

  /// The *_b attributes are in use from here on: particles that live already get copies of what they were at birth.
  void keep_copies();

  /// Actions of the items that have not run yet, cut where callbacks stand. One piece at least.
  std::vector<Piece> pending_pieces() const;

  /// The frame's spawn rules so far, in order.
  std::vector<const recording::Spawn*> rules() const;

  /// All items so far have run.
  void mark_run() { run_items = list.size(); }
  bool pending() const { return run_items < list.size(); }
  void start_frame();

  recording::SystemDefinition definition;
  particles::Schema schema;
  particles::Key key;
  domains::Domains domains;
  bool waits_for_fit = false;       // space "fit", and no birth yet
  bool new_cuts = false;            // manager: the other ranks have not been told
  std::optional<domains::Domains> next_domains;  // manager: from the next frame's births on
  balance::Speeds speeds;           // manager: of all calculators; elsewhere: of this one alone
  std::vector<balance::Load> loads;  // manager: after the exchange of this frame, one a calculator
  balance::Plan plan;               // manager: what this frame's loads call for
  std::uint64_t evaluations = 0;    // how often cuts were looked at
  std::unique_ptr<particles::Store> store;
  image::Sprite sprite;
  bool keeps_copies = false;
  BirthHistory history;  // calculators: until copies are kept

  std::vector<recording::Item> list;  // this frame's
  std::size_t run_items = 0;          // of which have run
  bool moved = false;                 // positions may have changed since leavers were looked for

  std::uint64_t born = 0;             // ids given so far
  std::uint64_t alive = 0;            // last agreed global number
  std::uint64_t alive_at_start = 0;   // of the frame: what the capacity is held against
  std::uint64_t born_this_frame = 0;
  std::uint64_t dropped = 0;          // births above the capacity so far
  recording::Outcome outcome;
  Tally tally;

  std::vector<Sent> sent;             // leavers of this frame, by domain

  std::vector<std::vector<recording::Event>> events;  // one list a rule: parents on this rank
  std::uint64_t spawned = 0;  // children of all rules and ranks that the next frame starts with
  BirthGroup children;  // of which this frame starts with so many
  std::vector<recording::Offspring> offspring;       // manager: what they are made of
  std::vector<recording::Offspring> next_offspring;  // the next frame's
};

}  // namespace motes::frame
