#include "engine/act/interact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "base/fields.h"
#include "comm/clock.h"
#include "engine/act/act.h"
#include "engine/act/follow.h"
#include "engine/act/ghost_exchange.h"
#include "engine/act/parties.h"
#include "engine/act/run_list.h"
#include "engine/births/spawn.h"
#include "engine/session/all_reduce.h"
#include "engine/session/item_failure.h"
#include "interactions/act.h"
#include "interactions/clumps.h"
#include "interactions/pyramid.h"
#include "interactions/scripted.h"
#include "particles/wrap.h"
#include "program/select.h"

namespace motes::engine {

using comm::Message;
using comm::Phase;
using particles::Store;

namespace {

// One interaction on this calculator, and the values that all calculators agreed on for it.
class PairInteraction {
 public:
  explicit PairInteraction(const Parties& parties) : in_(parties) {
    if (bonds_ == nullptr) return;
    pins_.assign(3 * bonds_->pins(), -std::numeric_limits<float>::infinity());
  }

  bool run() {
    prepare();
    if (!agree()) return false;
    kept_ ? exchange_.refresh() : exchange_.exchange(farthest_, range_);
    if (interactions::uses_cells(*in_.interaction.action)) add_moments();
    in_.compute([&] { act(); });
    return true;
  }

 private:
  using Extent = interactions::Extent;

  interactions::Knots& knots() {
    return in_.calculator
        .knots[{in_.interaction.systems[0], std::get<actions::TiedPairs>(in_.interaction.action->specifics).ties}];
  }
  float dt() const { return static_cast<float>(in_.rank.settings.dt / in_.rank.settings.substeps); }

  // Clears the dead, finds migrants unless the neighbour lists can be kept, and computes the values to agree on.
  void prepare() {
    in_.compute([&] {
      for (std::size_t side = 0; side < in_.interaction.count; ++side)
        clear_dead(in_.rank, in_.system(side), in_.population(side));
      kept_ = exchange_.has_lists() && exchange_.holds();
      if (!kept_) exchange_.find_migrants();
      for (std::size_t side = 0; side < in_.interaction.count; ++side) {
        const Population& here = in_.population(side);
        if (interactions::uses_cells(*in_.interaction.action)) bounds_ = interactions::bounds_of(here.store);
        if (bonds_ != nullptr) prepare_ties(here.store);
        const Extent extent = interactions::extent_of(in_.action(side), here.store, dt(), side == 1, *in_.rank.pool);
        extent_.radius = std::max(extent_.radius, extent.radius);
        extent_.other_radius = std::max(extent_.other_radius, extent.other_radius);
        extent_.displacement = std::max(extent_.displacement, extent.displacement);
        extent_.masses = std::max(extent_.masses, extent.masses);
      }
    });
  }

  void prepare_ties(const Store& store) {
    pins_ = interactions::pins_of(*bonds_, store);
    if (in_.rank.session.calculators() == 1) return;  // sees all particles
    const interactions::TieBounds stretch =
        interactions::stretch_of(*bonds_, knots(), store, in_.system(0).definition.periods);
    extent_.radius = stretch.longest;
    extent_.displacement = stretch.way;
  }

  // Element 0 is a failure flag; ranks that can still communicate always send it.
  bool agree() {
    const auto farthest = static_cast<float>(exchange_.farthest());
    Maxima numbers = {in_.rank.session.failed() ? 1.0f : 0.0f,
                      std::nextafter(farthest, std::numeric_limits<float>::infinity()),
                      extent_.radius,
                      extent_.other_radius,
                      extent_.displacement,
                      extent_.masses,
                      kept_ ? 0.0f : 1.0f,
                      exchange_.wear().step,
                      exchange_.wear().age};
    const std::size_t fixed = numbers.size();
    numbers.insert(numbers.end(), pins_.begin(), pins_.end());
    numbers.insert(numbers.end(), bounds_.begin(), bounds_.end());
    const Maxima heard = all_reduce_max(in_.rank, in_.round, std::move(numbers));
    if (heard[0] != 0) return false;
    extent_ = {heard[2], heard[3], heard[4], interactions::rounding_at(farthest_face()), heard[5]};
    std::copy_n(heard.begin() + static_cast<std::ptrdiff_t>(fixed), pins_.size(), pins_.begin());
    std::copy_n(heard.begin() + static_cast<std::ptrdiff_t>(fixed + pins_.size()), bounds_.size(), bounds_.begin());
    farthest_ = heard[1];
    const bool held = kept_;
    kept_ = heard[6] == 0;
    if (exchange_.has_lists()) skin_ = skin({heard[7], heard[8]});
    range_ = interactions::range_of(*in_.interaction.action, extent_) + static_cast<double>(skin_);
    if (held && !kept_) in_.compute([&] { exchange_.find_migrants(); });
    if (interactions::uses_cells(*in_.interaction.action)) {
      const Counts& counts = in_.system(0).counts;  // an upper bound that is the same on all ranks
      cube_ = interactions::Cube::around(bounds_, counts.alive_at_start + counts.born - counts.born_at_start);
      range_ = 2 * cube_.leaf;
    }
    return true;
  }

  // Returns the skin of newly built neighbour lists, m.
  float skin(const interactions::Wear& wear) const {
    const float reach = interactions::reach_of(*in_.interaction.action, extent_);
    const std::optional<float>& told = in_.rank.settings.skin;
    return std::min(told ? *told * reach : interactions::skin_of(wear, reach), images_.most_skin(reach));
  }

  float farthest_face() const {
    float most = 2 * images_.farthest_end();  // images are beyond the ends of space
    for (std::size_t side = 0; side < in_.interaction.count; ++side) {
      most = std::max(most, in_.system(side).domains.farthest_face());
    }
    return most;
  }

  void add_moments() {
    in_.compute([&] { moments_ = interactions::moments_of(cube_, in_.population(0).store); });
    moments_.resize(4 * cube_.leaves());
    in_.population(0).interaction.bytes += all_reduce_sum(in_.rank, in_.round, Phase::interaction, moments_);
  }

  // Calls the script's function of pairs and returns its changes.
  std::vector<float> ask(const interactions::PairList& pairs) {
    std::vector<float> changes;
    if (pairs.size() == 0) return changes;
    const Call call{static_cast<int>(in_.interaction.systems[0]),
                    static_cast<int>(actions::numbers_of<actions::numbers::pairs>(*in_.interaction.action).number),
                    0,
                    nullptr,
                    &pairs,
                    &changes};
    ask_script(in_.calculator, in_.population(0), call);
    return changes;
  }

  // Removes newborn particles that overlapped others. They never took part, so spawn rules do not count their deaths.
  void drop(Population& here, const std::vector<std::uint32_t>& dropped) const {
    if (dropped.empty()) return;
    here.store.remove(dropped, *in_.rank.pool);
    here.tally.killed += dropped.size();
  }

  interactions::InteractionCounts look(const interactions::Side (&sides)[2]) {
    const actions::Action& action = *in_.interaction.action;
    if (bonds_ != nullptr) {
      return {interactions::tie(action, *bonds_, dt(), in_.system(0).definition.periods, sides[0], pins_, knots(),
                                *in_.rank.pool),
              0};
    }
    if (interactions::uses_cells(action)) {
      return interactions::act_by_cells(action, cube_, moments_, dt(), sides[0], in_.calculator.scratch,
                                        *in_.rank.pool);
    }
    if (action.kind == actions::Kind::pairs) {
      const auto procedure = [&](const interactions::PairList& pairs) { return ask(pairs); };
      return interactions::act_on_pairs(action, sides[0], procedure, in_.calculator.scratch, *in_.rank.pool);
    }
    if (action.kind == actions::Kind::interact) {
      return interactions::act_by_script(action, in_.interaction.time, dt(), sides, in_.calculator.scratch,
                                         *in_.rank.pool);
    }
    if (const actions::Action* const other = in_.interaction.counterpart; other != nullptr) {
      return interactions::contact_between({&action, other}, extent_, dt(), sides, in_.calculator.scratch,
                                           *in_.rank.pool);
    }
    return interactions::act(action, extent_, dt(), sides, in_.calculator.scratch, *in_.rank.pool);
  }

  // Adds the forces on the action's walls to those of earlier sub-steps.
  void note_walls(const interactions::WallSums& walls) {
    WallForces& forces = in_.population(0).walls;
    for (const auto& [wall, sum] : walls) forces[{static_cast<std::uint32_t>(in_.interaction.item), wall}] += sum;
  }

  void act() {
    images_.check(*in_.interaction.action, interactions::reach_of(*in_.interaction.action, extent_));
    interactions::Side sides[2];
    std::vector<std::uint8_t> chosen[2], collided[2];
    for (std::size_t side = 0; side < in_.interaction.count; ++side) {
      Population& here = in_.population(side);
      sides[side] = {&here.store, &exchange_.ghosts(side), nullptr, in_.interaction.newborn_from[side]};
      sides[side].gravity = in_.interaction.gravity[side];
      sides[side].adds = in_.interaction.collided[side] != Collided::none;
      if (interactions::remembers(*in_.interaction.action)) {
        sides[side].list = &exchange_.list_of(side);
        sides[side].law = in_.interaction.law[side];
        sides[side].place = in_.place(side);
        sides[side].kept = kept_;
        sides[side].skin = skin_;
      }
      sides[side].now = in_.interaction.substep;
      sides[side].start = in_.interaction.start;
      sides[side].end = in_.interaction.end;
      sides[side].last = in_.interaction.last;
      here.moved = true;
      if (in_.interaction.collided[side] == Collided::some) {
        collided[side] = collided_of(here);
        sides[side].adds_to = &collided[side];
      }
      if (in_.interaction.action->where.empty() || side == 1) continue;
      chosen[side].assign(here.store.size(), 0);
      for (const std::uint32_t p : program::select(in_.interaction.action->where, in_.interaction.action->shapes,
                                                   in_.interaction.time, here.store)) {
        chosen[side][p] = 1;
      }
      sides[side].chosen = &chosen[side];
    }
    const interactions::InteractionCounts seen = look(sides);
    note_walls(seen.walls);
    for (std::size_t side = 0; side < in_.interaction.count; ++side) {
      if (in_.interaction.collides_again[side]) note_collided(in_.population(side), sides[side].chosen);
    }
    for (std::size_t side = 0; side < in_.interaction.count; ++side) {
      drop(in_.population(side), seen.dropped[side]);
      particles::wrap(in_.population(side).store, *in_.rank.pool);  // a scripted law may set positions
    }
    InteractionStats& stats = in_.population(0).interaction;
    stats.pairs += seen.pairs;
    stats.most_in_a_cell = std::max(stats.most_in_a_cell, seen.most_in_a_cell);
    stats.overlap_99 = std::max(stats.overlap_99, seen.overlap_99);
    for (std::size_t side = 0; side < in_.interaction.count; ++side) {
      const float substeps = interactions::substeps(in_.action(side), extent_, in_.rank.settings.dt);
      stats.substeps = std::max(stats.substeps, static_cast<std::uint16_t>(std::min(substeps, 65535.0f)));
    }
  }

  const Parties& in_;
  const std::shared_ptr<const interactions::Bonds> bonds_ =  // null unless the action is a tie
      in_.interaction.action->kind == actions::Kind::tie
          ? interactions::bonds(std::get<actions::TiedPairs>(in_.interaction.action->specifics).ties)
          : nullptr;
  const Images images_{in_.system(0).definition.periods};
  GhostExchange exchange_{in_, bonds_.get(), images_};
  bool kept_ = false;  // neighbour lists and ghosts are kept
  float skin_ = 0;     // metres
  Extent extent_;
  double farthest_ = 0;
  double range_ = 0;
  std::vector<float> pins_;                       // tie: positions of the pinned particles
  interactions::Bounds bounds_{};                     // actions by cells: bounds of all particles
  interactions::Cube cube_;
  interactions::Moments moments_;
};

}  // namespace

bool interact(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
              const Interaction& interaction) {
  const double start = comm::wall_seconds();
  const double waited = rank.session.comm().waited_s();
  const bool done = interaction.action->kind == actions::Kind::follow
                        ? follow(rank, script, calculator, round, interaction)
                        : PairInteraction({rank, script, calculator, round, interaction}).run();
  InteractionStats& stats = calculator.populations[interaction.systems[0]]->interaction;
  ++stats.interactions;
  stats.interact_s += static_cast<float>(comm::wall_seconds() - start);
  stats.wait_s += static_cast<float>(rank.session.comm().waited_s() - waited);
  return done;
}

void say_failed(Rank& rank, const Round& round) { all_reduce_max(rank, round, {1}); }

}  // namespace motes::engine
