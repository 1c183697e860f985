// What one calculator has of a system: its particles, and what happened to them in this frame.
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
#include "engine/state/system.h"
#include "interactions/act.h"
#include "interactions/tie.h"
#include "particles/store.h"
#include "program/program.h"
#include "recording/spawn.h"

namespace motes::engine {

/// What the script reads where the list may not run in parts: a copy that has run the items so far.
struct Preview {
  particles::Store store;
  std::size_t dead;   // stand behind the others
  std::size_t items;  // of the list, that have run
  BirthHistory history;  // with the births of these items
};

/// Which particles of a system have collided in this sub-step: their contacts count from then on.
enum class Collided : std::uint8_t { none, some, all };

struct Population {
  explicit Population(const particles::Schema& schema) : store(schema) {}

  /// How many particles a script sees: the dead of this frame stand behind them until it ends.
  std::size_t seen() const { return store.size() - outcome.dead.size(); }

  particles::Store store;
  std::unique_ptr<Preview> preview;
  bool in_callback = false;                   // the script sees all that the list runs over
  bool moved = false;                         // positions may have changed since migrants were looked for
  program::Outcome outcome;
  std::set<std::uint64_t>
      bounced;  // ids of those here that did so before the last interaction, where a rule asks for it
  std::unordered_set<std::uint64_t> collided;  // the same of those that did so in this sub-step, where only some did
  Tally tally;
  InteractionStats interaction;
  std::vector<Sent> sent;  // migrants of this frame, by domain
  std::vector<std::vector<recording::Event>> events;  // one list per rule: parents on this rank
  std::uint64_t oldest = 0;  // the lowest id here, where the history asks for it
  particles::Digest digest;  // where the conversation asks for it
  balance::Speeds speeds;  // this calculator's
  balance::Load expected;  // behind the exchange, as far as that is known before it: see expected_of
};

/// One call of a function of the script: of particles `begin`.. of a system or, where a condition stands, of those at
/// the indices `chosen`.
struct Call {
  int system;
  int callback;  // its number
  std::size_t begin;
  const std::vector<std::uint32_t>* chosen;
  const interactions::PairList* pairs = nullptr;  // of a procedure of pairs
  std::vector<float>* changes = nullptr;  // what that says: three numbers each, or nothing
};

/// What a calculator keeps, per system. Ranks that do not calculate have empty populations.
struct Calculator {
  std::vector<std::unique_ptr<Population>> populations;
  std::function<void(const Call&)> callback;
  interactions::Scratch scratch;  // of interactions, one after another
  std::map<std::pair<std::size_t, interactions::TiesKey>, interactions::Knots> knots;  // by system
  Tail tail;  // what the next report tells of the last frame
  std::vector<CalculatorTail> tails;  // and, for the log, of each system
};

/// 0, 1, ... count - 1.
std::vector<std::uint32_t> first_indices(std::size_t count);

/// For each particle, whether it stands in `collided`.
std::vector<std::uint8_t> collided_of(const Population& here);
/// These collide, or all, where none needs to be noted; null: all.
void note_collided(Population& here, const std::vector<std::uint8_t>* chosen);

/// Starts a frame: nothing has happened yet.
void start_frame(Population& here);

/// The *_b attributes are in use from here on: particles that live already, also those of a preview, get copies of what
/// they were at birth.
void keep_copies(System& system, Population& here);

}  // namespace motes::engine
