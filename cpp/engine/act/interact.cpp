#include "engine/act/interact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "comm/clock.h"
#include "engine/act/act.h"
#include "engine/act/follow.h"
#include "engine/act/ghost_exchange.h"
#include "engine/act/parties.h"
#include "engine/births/spawn.h"
#include "engine/session/all_reduce.h"
#include "interactions/kinds/families.h"
#include "particles/wrap.h"
#include "program/select.h"

namespace motes::engine {

using comm::Phase;
using interactions::Meeting;
using interactions::Side;

namespace {

// Returns the meeting with this rank's particles.
Meeting meeting_of(const Parties& in) {
  Meeting meeting = in.interaction.meeting;
  for (std::size_t s = 0; s < meeting.count; ++s) {
    Side& side = meeting.sides[s];
    const Counts& counts = in.system(s).counts;
    side.store = &in.population(s).store;
    side.everywhere = counts.alive_at_start + counts.born - counts.born_at_start;
    if (interactions::remembers(*side.action)) side.kept.list = &in.calculator.neighbours[in.key(s)];
  }
  meeting.periods = &in.system(0).definition.periods;
  meeting.all_here = in.rank.session.calculators() == 1;
  meeting.scratch = &in.calculator.scratch;
  meeting.pool = in.rank.pool.get();
  return meeting;
}

// One interaction on this calculator, and what all calculators agreed on for it.
class PairInteraction {
 public:
  explicit PairInteraction(const Parties& parties) : in_(parties) {
    meeting_.ask_script = [this](const interactions::PairList& pairs) { return ask(pairs); };
    for (std::size_t s = 0; s < meeting_.count; ++s) meeting_.sides[s].ghosts = &exchange_.ghosts(s);
  }
  PairInteraction(const PairInteraction&) = delete;  // the action refers to the meeting
  PairInteraction& operator=(const PairInteraction&) = delete;

  bool run() {
    prepare();
    if (!agree()) return false;
    kept_ ? exchange_.refresh() : exchange_.exchange(static_cast<double>(agreed_.outside), range_);
    add_up();
    in_.compute([&] { act(); });
    return true;
  }

 private:
  // Clears the dead, finds migrants unless the neighbour lists can be kept, and measures the particles.
  void prepare() {
    in_.compute([&] {
      for (std::size_t s = 0; s < meeting_.count; ++s) clear_dead(in_.rank, in_.system(s), in_.population(s));
      kept_ = exchange_.has_lists() && exchange_.holds();
      if (!kept_) exchange_.find_migrants();
      agreed_ = action_->own();
    });
  }

  // Lists are kept only if they hold on all ranks. A rank whose lists would have held then finds its migrants after
  // all, since the others send theirs.
  bool agree() {
    agreed_.outside = std::nextafter(static_cast<float>(exchange_.farthest()), std::numeric_limits<float>::infinity());
    agreed_.worn = kept_ ? 0.0f : 1.0f;
    agreed_.wear = exchange_.wear();
    if (!agree_on_maxima(in_.rank, in_.round, agreed_)) return false;
    agreed_.extent.rounding = interactions::rounding_at(farthest_face());
    const bool held = std::exchange(kept_, agreed_.worn == 0);
    const float skin = exchange_.has_lists() ? this->skin() : 0;
    for (std::size_t s = 0; s < meeting_.count; ++s) {
      meeting_.sides[s].kept.holds = kept_;
      meeting_.sides[s].kept.skin = skin;
    }
    range_ = action_->range(agreed_) + static_cast<double>(skin);
    if (held && !kept_) in_.compute([&] { exchange_.find_migrants(); });
    return true;
  }

  // Returns the skin of newly built neighbour lists, m.
  float skin() const {
    const float reach = action_->reach(agreed_);
    const std::optional<float>& told = in_.rank.settings.skin;
    const bool near = interactions::law_of(*meeting_.sides[0].action).near;
    return std::min(told ? *told * reach : interactions::skin_of(agreed_.wear, reach, near), images_.most_skin(reach));
  }

  float farthest_face() const {
    float most = 2 * images_.farthest_end();  // images are beyond the ends of space
    for (std::size_t s = 0; s < meeting_.count; ++s) most = std::max(most, in_.system(s).domains.farthest_face());
    return most;
  }

  // Adds up integers over all ranks. A rank that has failed adds zeros: the others count on its messages.
  void add_up() {
    const std::size_t count = action_->to_add(agreed_);
    if (count == 0) return;
    in_.compute([&] { agreed_.sums = action_->own_to_add(agreed_); });
    agreed_.sums.resize(count);
    in_.population(0).interaction.bytes += all_reduce_sum(in_.rank, in_.round, Phase::interaction, agreed_.sums);
  }

  // Calls the script's function of pairs and returns its changes.
  std::vector<float> ask(const interactions::PairList& pairs) {
    std::vector<float> changes;
    if (pairs.size() == 0) return changes;
    const auto given = actions::numbers_of<actions::numbers::pairs>(*meeting_.sides[0].action);
    const Call call{static_cast<int>(in_.number(0)), static_cast<int>(given.number), 0, nullptr, &pairs, &changes};
    ask_script(in_.calculator, in_.population(0), call);
    return changes;
  }

  // Removes newborn particles that overlapped others. They never took part, so spawn rules do not count their deaths.
  void drop(Population& here, const std::vector<std::uint32_t>& dropped) const {
    if (dropped.empty()) return;
    here.store.remove(dropped, *in_.rank.pool);
    here.tally.killed += dropped.size();
  }

  // Adds the forces on the action's walls to those of earlier sub-steps.
  void note_walls(const interactions::WallSums& walls) {
    WallForces& forces = in_.population(0).walls;
    for (const auto& [wall, sum] : walls) forces[{static_cast<std::uint32_t>(in_.interaction.item), wall}] += sum;
  }

  // Finds out which particles may change, and whose contacts are added to earlier ones. Both change with the exchange.
  void choose() {
    for (std::size_t s = 0; s < meeting_.count; ++s) {
      Population& here = in_.population(s);
      here.moved = true;
      interactions::Collisions& collisions = meeting_.sides[s].collisions;
      collisions.adds = in_.interaction.collided[s] != Collided::none;
      if (in_.interaction.collided[s] != Collided::some) continue;
      collided_[s] = collided_of(here);
      collisions.adds_to = &collided_[s];
    }
    const actions::Action& action = *meeting_.sides[0].action;
    if (action.where.empty()) return;
    particles::Store& store = in_.population(0).store;
    chosen_.assign(store.size(), 0);
    for (const std::uint32_t p : program::select(action.where, action.shapes, meeting_.step.time, store))
      chosen_[p] = 1;
    meeting_.sides[0].chosen = &chosen_;
  }

  void act() {
    images_.check(*action_, action_->reach(agreed_));
    choose();
    const interactions::InteractionCounts seen = action_->act(agreed_);
    note_walls(seen.walls);
    for (std::size_t s = 0; s < meeting_.count; ++s) {
      if (in_.interaction.collides_again[s]) note_collided(in_.population(s), meeting_.sides[s].chosen);
    }
    for (std::size_t s = 0; s < meeting_.count; ++s) {
      drop(in_.population(s), seen.dropped[s]);
      const bool moves = (actions::writes(*meeting_.sides[s].action) >> particles::position & 1) != 0;
      if (moves) particles::wrap(in_.population(s).store, *in_.rank.pool);  // a scripted law may set positions
    }
    InteractionStats& stats = in_.population(0).interaction;
    stats.pairs += seen.pairs;
    stats.most_in_a_cell = std::max(stats.most_in_a_cell, seen.most_in_a_cell);
    stats.overlap_99 = std::max(stats.overlap_99, seen.overlap_99);
    const float substeps = action_->substeps(agreed_, in_.rank.settings.dt);
    stats.substeps = std::max(stats.substeps, static_cast<std::uint16_t>(std::min(substeps, 65535.0f)));
  }

  const Parties& in_;
  Meeting meeting_ = meeting_of(in_);
  const std::unique_ptr<interactions::PairAction> action_ = interactions::begin(meeting_);
  const Images images_{in_.system(0).definition.periods};
  GhostExchange exchange_{in_, *action_, images_};
  interactions::Agreement agreed_;
  bool kept_ = false;  // neighbour lists and ghosts are kept
  double range_ = 0;   // of ghosts, m
  std::vector<std::uint8_t> chosen_, collided_[2];  // by index
};

}  // namespace

bool interact(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
              const Interaction& interaction) {
  const double start = comm::wall_seconds();
  const double waited = rank.session.comm().waited_s();
  const Side& first = interaction.meeting.sides[0];
  const bool done = first.action->kind == actions::Kind::follow
                        ? follow(rank, script, calculator, round, interaction)
                        : PairInteraction({rank, script, calculator, round, interaction}).run();
  InteractionStats& stats = calculator.populations[first.system]->interaction;
  ++stats.interactions;
  stats.interact_s += static_cast<float>(comm::wall_seconds() - start);
  stats.wait_s += static_cast<float>(rank.session.comm().waited_s() - waited);
  return done;
}

void say_failed(Rank& rank, const Round& round) { all_reduce_max(rank, round, {1}); }

}  // namespace motes::engine
