#include "engine/act/interact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/fields.h"
#include "comm/clock.h"
#include "engine/act/act.h"
#include "engine/act/follow.h"
#include "engine/act/run_list.h"
#include "engine/births/spawn.h"
#include "engine/session/all_reduce.h"
#include "engine/session/item_failure.h"
#include "interactions/act.h"
#include "interactions/pyramid.h"
#include "interactions/scripted.h"
#include "program/select.h"

namespace motes::engine {

using comm::Message;
using comm::Phase;
using particles::Store;

namespace {

// Returns the distance of two intervals, m; symmetric in both.
double gap(double low, double high, double other_low, double other_high) {
  return std::max({0.0, low - other_high, other_low - high});
}

double gap(const domains::Box& a, const domains::Box& b) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) most = std::max(most, gap(a.low[c], a.high[c], b.low[c], b.high[c]));
  return most;
}

// Returns the distance of a point from the box, m; infinite for NaN, which may belong to any calculator.
double outside(const domains::Box& box, const float (&x)[3]) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::isnan(x[c])) return std::numeric_limits<double>::infinity();
    most = std::max(most, gap(box.low[c], box.high[c], x[c], x[c]));
  }
  return most;
}

void position_of(const Store& store, std::size_t i, float (&x)[3]) {
  for (int c = 0; c < 3; ++c) x[c] = store.value(particles::position, c, i);
}

// Migrants since the last interaction, by new owner.
struct Migrants {
  std::map<int, std::vector<std::uint32_t>> to;
  double farthest = 0;  // metres outside the domain
};

Migrants migrants_of(const Rank& rank, const System& system, Population& here) {
  Migrants migrants;
  find_migrants(rank, system, here);
  migrants.to = migrants_by_owner(rank, system, here);
  here.outcome.left.clear();
  const domains::Box box = system.domains.box(rank.session.calculator());
  for (const auto& [owner, particles] : migrants.to) {
    for (const std::uint32_t p : particles) {
      float x[3];
      position_of(here.store, p, x);
      migrants.farthest = std::max(migrants.farthest, outside(box, x));
    }
  }
  return migrants;
}

// Swaps migrants and ghosts for an interaction: what this calculator sends to whom, and what all agreed on.
class GhostExchange {
 public:
  GhostExchange(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
                const Interaction& interaction)
      : rank_(rank), script_(script), calculator_(calculator), round_(round), interaction_(interaction) {
    if (interaction.action->kind != actions::Kind::tie) return;
    bonds_ = interactions::bonds(interaction.action->ties);
    pins_.assign(3 * bonds_->pins(), -std::numeric_limits<float>::infinity());
  }

  bool run() {
    prepare();
    if (!agree()) return false;
    if (rank_.session.calculators() > 1) exchange();
    if (interactions::uses_cells(*interaction_.action)) add_moments();
    compute([&] { act(); });
    return true;
  }

 private:
  using Extent = interactions::Extent;

  const std::vector<recording::Item>& list() const { return system(0).list; }
  interactions::Knots& knots() { return calculator_.knots[{interaction_.systems[0], interaction_.action->ties}]; }
  const System& system(std::size_t side) const { return *script_.systems[interaction_.systems[side]]; }
  Population& population(std::size_t side) const { return *calculator_.populations[interaction_.systems[side]]; }
  float dt() const { return static_cast<float>(rank_.settings.dt / rank_.settings.substeps); }

  // The work of systems that meet counts by their numbers of particles.
  template <class Work>
  void compute(const Work& work) {
    rank_.session.work("meeting", [&] {
      const double spent =
          rank_.machine.timed([&] { of_item(list(), interaction_.systems[0], interaction_.item, work); });
      double all = 0;
      for (std::size_t side = 0; side < interaction_.count; ++side)
        all += static_cast<double>(population(side).store.size());
      for (std::size_t side = 0; side < interaction_.count; ++side) {
        const auto own = static_cast<double>(population(side).store.size());
        population(side).tally.compute_s += spent * (all > 0 ? own / all : 1 / static_cast<double>(interaction_.count));
      }
    });
  }

  // Clears the dead, finds who left, and what all must know.
  void prepare() {
    compute([&] {
      for (std::size_t side = 0; side < interaction_.count; ++side) {
        Population& here = population(side);
        clear_dead(rank_, system(side), here);
        if (interactions::uses_cells(*interaction_.action)) bounds_ = interactions::bounds_of(here.store);
        if (bonds_ != nullptr) prepare_ties(here.store);
        if (rank_.session.calculators() > 1) migrants_[side] = migrants_of(rank_, system(side), here);
        const Extent extent = interactions::extent_of(*interaction_.action, here.store, dt(), side == 1, *rank_.pool);
        extent_.radius = std::max(extent_.radius, extent.radius);
        extent_.other_radius = std::max(extent_.other_radius, extent.other_radius);
        extent_.displacement = std::max(extent_.displacement, extent.displacement);
        extent_.masses = std::max(extent_.masses, extent.masses);
      }
    });
  }

  void prepare_ties(const Store& store) {
    pins_ = interactions::pins_of(*bonds_, store);
    if (rank_.session.calculators() == 1) return;  // sees all that there is
    const interactions::Stretch stretch = interactions::stretch_of(*bonds_, knots(), store);
    extent_.radius = stretch.longest;
    extent_.displacement = stretch.way;
  }

  // Element 0 is a failure flag; ranks that can still communicate always send it.
  bool agree() {
    const double farthest = std::max(migrants_[0].farthest, migrants_[1].farthest);
    const float out = std::nextafter(static_cast<float>(farthest), std::numeric_limits<float>::infinity());
    Maxima word = {rank_.session.failed() ? 1.0f : 0.0f,
                   out,
                   extent_.radius,
                   extent_.other_radius,
                   extent_.displacement,
                   extent_.masses};
    const std::size_t fixed = word.size();
    word.insert(word.end(), pins_.begin(), pins_.end());
    word.insert(word.end(), bounds_.begin(), bounds_.end());
    const Maxima heard = all_reduce_max(rank_, round_, std::move(word));
    if (heard[0] != 0) return false;
    extent_ = {heard[2], heard[3], heard[4], interactions::rounding_at(farthest_cut()), heard[5]};
    std::copy_n(heard.begin() + static_cast<std::ptrdiff_t>(fixed), pins_.size(), pins_.begin());
    std::copy_n(heard.begin() + static_cast<std::ptrdiff_t>(fixed + pins_.size()), bounds_.size(), bounds_.begin());
    farthest_ = heard[1];
    range_ = interactions::range_of(*interaction_.action, extent_);
    if (interactions::uses_cells(*interaction_.action)) {
      const Counts& counts = system(0).counts;  // at most so many live: all ranks know the same
      cube_ = interactions::Cube::around(bounds_, counts.alive_at_start + counts.born - counts.born_at_start);
      range_ = 2 * cube_.leaf;
    }
    return true;
  }

  float farthest_cut() const {
    float most = 0;
    for (std::size_t side = 0; side < interaction_.count; ++side) {
      for (const float cut : system(side).domains.cuts()) most = std::max(most, std::abs(cut));
    }
    return most;
  }

  // Tells whether one calculator may have migrants or ghosts for another.
  bool concerns(int from, int to) const {
    for (std::size_t a = 0; a < interaction_.count; ++a) {
      const domains::Box box = system(a).domains.box(from);
      if (gap(box, system(a).domains.box(to)) <= farthest_) return true;
      if (gap(box, system(seer(a)).domains.box(to)) <= farthest_ + range_) return true;
    }
    return false;
  }

  // Returns the side whose particles see those of this side: itself, or the other system.
  std::size_t seer(std::size_t side) const { return interaction_.count == 1 ? 0 : 1 - side; }

  void exchange() {
    const int self = rank_.session.calculator();
    const int count = static_cast<int>(rank_.session.calculators());
    std::vector<int> to;
    std::vector<int> from;
    for (int other = 0; other < count; ++other) {
      if (other != self && concerns(self, other)) to.push_back(other);
      if (other != self && concerns(other, self)) from.push_back(other);
    }
    std::uint16_t& hops = population(0).interaction.hops;
    hops = std::max(hops, static_cast<std::uint16_t>(std::min<std::size_t>(to.size(), UINT16_MAX)));
    for (const int source : from) rank_.session.comm().await(rank_.session.rank_of(source), Phase::interaction);
    std::map<int, Message> messages;
    for (const int target : to) messages[target];
    compute([&] {
      for (std::size_t side = 0; side < interaction_.count; ++side) pack(side, messages);
    });
    for (auto& [target, message] : messages) {
      if (rank_.session.failed()) message = Message();
      const std::uint64_t count = rank_.session.failed() ? 0 : sent_[target];
      population(0).interaction.bytes += message.payload().size();
      rank_.session.comm().post(rank_.session.rank_of(target), Phase::interaction, rank_.session.stamp(round_),
                                std::move(message), count, rank_.session.failed());
    }
    compute([&] {
      for (std::size_t side = 0; side < interaction_.count; ++side) remove_migrants(side);
    });
    for (const int source : from) {
      const Message message =
          rank_.session.comm().expect(rank_.session.rank_of(source), Phase::interaction, rank_.session.stamp(round_));
      if (message.header().failed == 0) compute([&] { unpack(message); });
    }
  }

  void add_moments() {
    compute([&] { moments_ = interactions::moments_of(cube_, population(0).store); });
    moments_.resize(4 * cube_.leaves());
    population(0).interaction.bytes += all_reduce_sum(rank_, round_, Phase::interaction, moments_);
  }

  // The particles that somebody else may see, or that leave.
  std::vector<std::uint32_t> near_the_border(std::size_t side) const {
    const System& sees = system(seer(side));
    const Store& store = population(side).store;
    const domains::Box own = system(side).domains.box(rank_.session.calculator());
    if (sees.domains != system(side).domains || own == domains::Box{}) return first_indices(store.size());
    std::vector<std::uint8_t> near(store.size(), 0);
    for (int c = 0; c < 3; ++c) {
      const auto a = static_cast<std::size_t>(c);
      if (std::isinf(own.low[a]) && std::isinf(own.high[a])) continue;
      const double low = static_cast<double>(own.low[a]) + range_;
      const double high = static_cast<double>(own.high[a]) - range_;
      const float* plane = store.plane(particles::position, c);
      if (plane == nullptr) return first_indices(store.size());
      for (std::size_t i = 0; i < store.size(); ++i) {
        const double x = static_cast<double>(plane[i]);
        near[i] = near[i] | static_cast<std::uint8_t>(!(x > low && x < high));
      }
    }
    std::vector<std::uint32_t> found;
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (near[i] != 0) found.push_back(static_cast<std::uint32_t>(i));
    }
    return found;
  }

  void put_ghosts(std::size_t side, const std::vector<std::uint32_t>& chosen, base::Bytes& out) const {
    const Store& store = population(side).store;
    out.put(static_cast<std::uint64_t>(chosen.size()));
    for (const std::uint32_t i : chosen) out.put(store.ids()[i]);
    for (const interactions::Component c : interactions::read_by(*interaction_.action, side == 1)) {
      const float* plane = store.plane(c.attribute, c.component);
      const float value = store.uniform_value(c.attribute)[static_cast<std::size_t>(c.component)];
      for (const std::uint32_t i : chosen) out.put(plane != nullptr ? plane[i] : value);
    }
  }

  static std::uint64_t take_ghosts(base::Reader& in, std::size_t columns, interactions::Ghosts& ghosts) {
    const auto count = in.get<std::uint64_t>();
    ghosts.columns.resize(columns);
    for (std::uint64_t i = 0; i < count; ++i) ghosts.ids.push_back(in.get<std::uint64_t>());
    for (std::vector<float>& column : ghosts.columns) {
      for (std::uint64_t i = 0; i < count; ++i) column.push_back(in.get<float>());
    }
    return count;
  }

  // Packs, for each calculator, its new migrants and ghosts of particles within reach of its own.
  void pack(std::size_t side, std::map<int, Message>& messages) {
    Population& here = population(side);
    const int self = rank_.session.calculator();
    std::map<std::uint32_t, int> owners;
    for (const auto& [owner, migrants] : migrants_[side].to) {
      for (const std::uint32_t p : migrants) owners[p] = owner;
    }
    interactions::write_down_touches(calculator_.neighbours, interaction_.systems[side], owners, here.store);
    const domains::Domains& seen_by = system(seer(side)).domains;
    const std::vector<std::uint32_t> near = near_the_border(side);
    std::map<int, domains::Box> boxes{{self, seen_by.box(self)}};
    for (const auto& [target, message] : messages) boxes[target] = seen_by.box(target);
    const auto sees = [&](int who, std::uint32_t p) {
      float x[3];
      position_of(here.store, p, x);
      const bool tied = bonds_ == nullptr || bonds_->row_of(here.store.ids()[p]) != interactions::Bonds::kNone;
      return tied && !std::isnan(x[0] + x[1] + x[2]) && outside(boxes.at(who), x) <= range_;
    };
    const auto owner_of = [&](std::uint32_t p) {
      const auto migrant = owners.find(p);
      return migrant == owners.end() ? self : migrant->second;
    };
    // A particle is a ghost everywhere but at its owner.
    const auto copy_for = [&](int who, std::uint32_t p) { return owner_of(p) != who && sees(who, p); };
    for (auto& [target, message] : messages) {
      base::Bytes& bytes = message.bytes();
      const auto leaving = migrants_[side].to.find(target);
      const std::vector<std::uint32_t> none;
      const std::vector<std::uint32_t>& gone = leaving == migrants_[side].to.end() ? none : leaving->second;
      here.store.pack(gone, bytes, *rank_.pool);
      put_noted(here, here.bounced, gone, bytes);
      put_noted(here, here.collided, gone, bytes);
      std::vector<std::uint32_t> copied;
      for (const std::uint32_t p : near) {
        if (copy_for(target, p)) copied.push_back(p);
      }
      put_ghosts(side, copied, bytes);
      sent_[target] += gone.size() + copied.size();
      here.interaction.ghosts += copied.size();
      rank_.machine.charge(rank_.machine.costs().copy * static_cast<double>(copied.size()));
    }
    base::Bytes kept;  // migrants that this calculator still sees, packed
    std::vector<std::uint32_t> copied;
    for (const auto& [p, owner] : owners) {
      if (sees(self, p)) copied.push_back(p);
    }
    put_ghosts(side, copied, kept);
    base::Reader in(kept.view());
    take_ghosts(in, interactions::read_by(*interaction_.action, side == 1).size(), ghosts_[side]);
  }

  // Lists the migrants that are noted here, for their new owner to know.
  template <class Ids>
  static void put_noted(const Population& here, const Ids& noted, const std::vector<std::uint32_t>& gone,
                        base::Bytes& out) {
    std::vector<std::uint64_t> found;
    for (const std::uint32_t p : gone) {
      const std::uint64_t id = here.store.ids()[p];
      if (noted.contains(id)) found.push_back(id);
    }
    base::write_fields(found, out);
  }

  template <class Ids>
  static void take_noted(base::Reader& in, Ids& noted) {
    std::vector<std::uint64_t> found;
    base::read_fields(in, found);
    noted.insert(found.begin(), found.end());
  }

  void remove_migrants(std::size_t side) {
    Population& here = population(side);
    std::vector<std::uint32_t> gone;
    for (const auto& [owner, migrants] : migrants_[side].to) gone.insert(gone.end(), migrants.begin(), migrants.end());
    if (gone.empty()) return;
    std::sort(gone.begin(), gone.end());
    here.store.remove(gone, *rank_.pool);
    here.interaction.moved_out += gone.size();
    rank_.machine.charge(rank_.machine.costs().leave * static_cast<double>(gone.size()));
  }

  void unpack(const Message& message) {
    base::Reader in = message.reader();
    std::uint64_t count = 0;
    for (std::size_t side = 0; side < interaction_.count; ++side) {
      Population& here = population(side);
      const std::size_t before = here.store.size();
      here.store.unpack(in, *rank_.pool);
      const std::size_t arrived = here.store.size() - before;
      here.interaction.moved_in += arrived;
      take_noted(in, here.bounced);
      take_noted(in, here.collided);
      const std::uint64_t seen =
          take_ghosts(in, interactions::read_by(*interaction_.action, side == 1).size(), ghosts_[side]);
      count += arrived + seen;
      const Costs& costs = rank_.machine.costs();
      rank_.machine.charge(costs.arrive * static_cast<double>(arrived) + costs.copy * static_cast<double>(seen));
    }
    if (count != message.header().count || !in.done())
      throw std::runtime_error("particles were lost on the way between calculators");
  }

  // Calls the script's function with these pairs and returns its changes.
  std::vector<float> ask(const interactions::PairList& pairs) {
    std::vector<float> changes;
    if (pairs.size() == 0) return changes;
    const Call call{static_cast<int>(interaction_.systems[0]),
                    static_cast<int>(actions::numbers_of<actions::numbers::pairs>(*interaction_.action).number),
                    0,
                    nullptr,
                    &pairs,
                    &changes};
    ask_script(calculator_, population(0), call);
    return changes;
  }

  // Removes newborn particles that overlapped others. They never took part, so no spawn rule counts their death.
  void drop(Population& here, const std::vector<std::uint32_t>& dropped) const {
    if (dropped.empty()) return;
    here.store.remove(dropped, *rank_.pool);
    here.tally.killed += dropped.size();
  }

  interactions::Seen look(const interactions::Side (&sides)[2]) {
    const actions::Action& action = *interaction_.action;
    if (bonds_ != nullptr) {
      return {interactions::tie(action, *bonds_, dt(), sides[0], pins_, knots(), *rank_.pool), 0};
    }
    if (interactions::uses_cells(action)) {
      return interactions::act_by_cells(action, cube_, moments_, dt(), sides[0], calculator_.scratch, *rank_.pool);
    }
    if (action.kind == actions::Kind::pairs) {
      const auto procedure = [&](const interactions::PairList& pairs) { return ask(pairs); };
      return interactions::act_on_pairs(action, sides[0], procedure, calculator_.scratch, *rank_.pool);
    }
    if (action.kind == actions::Kind::interact)
      return interactions::act_by_script(action, interaction_.time, dt(), sides, calculator_.scratch, *rank_.pool);
    return interactions::act(action, extent_, dt(), sides, calculator_.scratch, *rank_.pool);
  }

  void act() {
    interactions::Side sides[2];
    std::vector<std::uint8_t> chosen[2], collided[2];
    for (std::size_t side = 0; side < interaction_.count; ++side) {
      Population& here = population(side);
      sides[side] = {&here.store, &ghosts_[side], nullptr, interaction_.newborn_from[side]};
      sides[side].adds = interaction_.collided[side] != Collided::none;
      if (interactions::remembers(*interaction_.action)) {
        sides[side].list = &calculator_.neighbours[{interaction_.systems[side], interaction_.law}];
        sides[side].law = interaction_.law;
        sides[side].keeps_list = rank_.session.calculators() == 1;
      }
      sides[side].now = interaction_.substep;
      sides[side].last = interaction_.last;
      here.moved = true;
      if (interaction_.collided[side] == Collided::some) {
        collided[side] = collided_of(here);
        sides[side].adds_to = &collided[side];
      }
      if (interaction_.action->where.empty() || side == 1) continue;
      chosen[side].assign(here.store.size(), 0);
      for (const std::uint32_t p :
           program::select(interaction_.action->where, interaction_.action->shapes, interaction_.time, here.store)) {
        chosen[side][p] = 1;
      }
      sides[side].chosen = &chosen[side];
    }
    const interactions::Seen seen = look(sides);
    for (std::size_t side = 0; side < interaction_.count; ++side) {
      if (interaction_.collides_again[side]) note_collided(population(side), sides[side].chosen);
    }
    for (std::size_t side = 0; side < interaction_.count; ++side) drop(population(side), seen.dropped[side]);
    InteractionStats& stats = population(0).interaction;
    stats.pairs += seen.pairs;
    stats.most_in_a_cell = std::max(stats.most_in_a_cell, seen.most_in_a_cell);
    stats.overlap_99 = std::max(stats.overlap_99, seen.overlap_99);
    if (seen.softened) stats.softened = 1;
  }

  Rank& rank_;
  const Script& script_;
  Calculator& calculator_;
  const Round& round_;
  const Interaction& interaction_;
  Migrants migrants_[2];
  Extent extent_;
  double farthest_ = 0;
  double range_ = 0;
  std::shared_ptr<const interactions::Bonds> bonds_;  // tie
  std::vector<float> pins_;                       // tie: where the pinned ones are
  interactions::Bounds bounds_{};                     // gravitate by cells
  interactions::Cube cube_;
  interactions::Moments moments_;
  std::map<int, std::uint64_t> sent_;  // migrants and ghosts
  interactions::Ghosts ghosts_[2];
};

}  // namespace

bool interact(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
              const Interaction& interaction) {
  const double start = comm::wall_seconds();
  const double waited = rank.session.comm().waited_s();
  const bool met = interaction.action->kind == actions::Kind::follow
                       ? follow(rank, script, calculator, round, interaction)
                       : GhostExchange(rank, script, calculator, round, interaction).run();
  InteractionStats& stats = calculator.populations[interaction.systems[0]]->interaction;
  ++stats.meetings;
  stats.meet_s += static_cast<float>(comm::wall_seconds() - start);
  stats.wait_s += static_cast<float>(rank.session.comm().waited_s() - waited);
  return met;
}

void say_failed(Rank& rank, const Round& round) { all_reduce_max(rank, round, {1}); }

}  // namespace motes::engine
