// A population: one calculator's particles of a system, and what happened to them in this frame.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <unordered_set>
#include <utility>
#include <vector>

#include "balance/load.h"
#include "engine/session/report.h"
#include "engine/state/kept_ghosts.h"
#include "engine/state/system.h"
#include "interactions/act.h"
#include "interactions/tie.h"
#include "particles/store.h"
#include "program/program.h"
#include "recording/spawn.h"

namespace motes::engine {

/// A preview, which the script reads if the list may not run in parts: a copy on which the items so far have run.
struct Preview {
  particles::Store store;
  std::size_t dead;   // stand behind the others
  std::size_t items;  // number of items of the list that have run
  BirthHistory history;  // birth history with the births of these items
};

/// Which particles of a system have collided in this sub-step, so that further contacts add up.
enum class Collided : std::uint8_t { none, some, all };

struct Population {
  explicit Population(const particles::Schema& schema) : store(schema) {}

  /// Returns the number of particles a script sees; the dead of this frame are stored behind them until it ends.
  std::size_t seen() const { return store.size() - outcome.dead.size(); }

  particles::Store store;
  std::unique_ptr<Preview> preview;
  bool in_callback = false;                   // the script sees all that the list runs over
  bool moved = false;                         // positions may have changed since migrants were looked for
  program::ListResult outcome;
  std::set<std::uint64_t> bounced;  // ids of those here that did so before the last meeting, where a rule asks for it
  std::unordered_set<std::uint64_t> collided;  // ids that collided in this sub-step, if only some did
  Tally tally;
  InteractionStats interaction;
  std::vector<Sent> sent;  // migrants of this frame, by domain
  std::vector<std::vector<recording::Event>> events;  // one list per rule: parents on this rank
  std::uint64_t oldest = 0;  // the lowest id here, where the history asks for it
  particles::Digest digest;  // only if the conversation asks for it
  balance::Speeds speeds;  // this calculator's
  balance::Load expected;  // expected load after the exchange: see expected_of
};

/// One call of a script's function: for particles from `begin` on, or with a condition for those at the indices
/// `chosen`.
struct Call {
  int system;
  int callback;  // number of the callback
  std::size_t begin;
  const std::vector<std::uint32_t>* chosen;
  const interactions::PairList* pairs = nullptr;  // arguments of a function of pairs
  std::vector<float>* changes = nullptr;  // its result: three numbers per pair, or nothing
};

/// The populations of a rank, one per system; empty on ranks that do not calculate.
struct Calculator {
  std::vector<std::unique_ptr<Population>> populations;
  std::function<void(const Call&)> callback;
  interactions::Scratch scratch;  // working memory of interactions
  // Kept neighbour lists, by system and contact: see Interaction::law.
  interactions::NeighbourLists neighbours;
  AllKeptGhosts ghosts;
  std::map<std::pair<std::size_t, interactions::TiesKey>, interactions::Knots> knots;  // by system
  Tail tail;  // what the next report tells of the last frame
  std::vector<CalculatorTail> tails;  // and, for the log, of each system
};

/// 0, 1, ... count - 1.
std::vector<std::uint32_t> first_indices(std::size_t count);

/// Returns, for each particle, whether it is in `collided`.
std::vector<std::uint8_t> collided_of(const Population& here);
/// These collide, or all, where none needs to be noted; null: all.
void note_collided(Population& here, const std::vector<std::uint8_t>* chosen);

/// Starts a frame: nothing has happened yet.
void start_frame(Population& here);

/// The *_b attributes are in use from here on: particles that live already, also those of a preview, get copies of what
/// they were at birth.
void keep_copies(System& system, Population& here);

}  // namespace motes::engine
