// A population: one calculator's particles of a system, and this frame's outcome for them.
#pragma once

#include <array>
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
#include "interactions/pairs.h"
#include "interactions/scratch.h"
#include "particles/store.h"
#include "program/program.h"
#include "recording/spawn.h"

namespace motes::engine {

/// A copy of the particles on which the items recorded so far have run. The script reads it if the list may not run in
/// parts.
struct Preview {
  particles::Store store;
  std::size_t dead;   // number of dead particles, stored after the others
  std::size_t items;  // number of items that have run
  BirthHistory history;  // includes the births of these items
};

/// Which particles of a system have collided in this sub-step; further collisions add to theirs.
enum class Collided : std::uint8_t { none, some, all };

struct Population {
  explicit Population(const particles::Schema& schema) : store(schema) {}

  /// Returns the number of particles a script sees; the dead of this frame are stored after them until it ends.
  std::size_t seen() const { return store.size() - outcome.dead.size(); }

  particles::Store store;
  std::unique_ptr<Preview> preview;
  bool in_callback = false;                   // the script sees all particles that the list runs over
  bool counts_afresh = true;                  // the hits are those of the last frame: see begin_counts
  bool moved = false;                         // positions may have changed since the last search for migrants
  program::ListResult outcome;
  std::set<std::uint64_t> bounced;  // ids that bounced before the last interaction, if a spawn rule needs them
  std::unordered_set<std::uint64_t> collided;  // ids that collided in this sub-step, if only some did
  Tally tally;
  Handling handling;
  std::array<float, kWays> ways{};  // see CalculatorTail
  InteractionStats interaction;
  WallForces walls;  // sums over this frame's sub-steps
  std::vector<Sent> sent;  // migrants of this frame, by domain
  std::vector<std::vector<recording::Event>> events;  // one list per spawn rule: parents on this rank
  std::uint64_t oldest = 0;  // the lowest id on this rank, if the history needs it
  particles::Digest digest;  // only in conversations that need it
  balance::Speeds speeds;
  balance::Load expected;  // load after the exchange: see expected_of
};

/// A call of a function of the script, for the particles from `begin` on or, with a condition, for those at the indices
/// `chosen`.
struct Call {
  int system;
  int callback;  // number of the callback
  std::size_t begin;
  const std::vector<std::uint32_t>* chosen;
  const interactions::PairList* pairs = nullptr;  // the arguments, if it is a function of pairs
  std::vector<float>* changes = nullptr;  // the result of a function of pairs: three numbers per pair, or none
};

/// The populations of a rank, one per system; empty on ranks that do not calculate.
struct Calculator {
  std::vector<std::unique_ptr<Population>> populations;
  std::function<void(const Call&)> callback;
  interactions::Scratch scratch;  // working memory of interactions
  // Kept neighbour lists, by system and action: see interactions::SideList.
  interactions::NeighbourLists neighbours;
  AllKeptGhosts ghosts;
  Tail tail;  // results of the last frame for the next report
  std::vector<CalculatorTail> tails;  // one per system: results of the last frame for the log
};

/// Returns 0, 1, ... count - 1.
std::vector<std::uint32_t> first_indices(std::size_t count);

/// Returns, for each particle, whether it is in `collided`.
std::vector<std::uint8_t> collided_of(const Population& here);
/// Notes the particles that collide in this sub-step; null: all of them, so no ids need to be stored.
void note_collided(Population& here, const std::vector<std::uint8_t>* chosen);

/// Resets the outcome of the last frame.
void start_frame(Population& here);

/// Forgets the hits of the last frame, before the first part of this frame's list runs. Until then scripts read them.
void begin_counts(Population& here);

/// Puts the *_b attributes into use: live particles, including those of a preview, get their values at birth.
void keep_copies(System& system, Population& here);

}  // namespace motes::engine
