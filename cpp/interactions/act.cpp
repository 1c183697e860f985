#include "interactions/act.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "interactions/clumps.h"
#include "interactions/overlap.h"
#include "interactions/walls.h"
#include "particles/blocks.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using actions::Action;

// Predicts a particle's position at the end of the step, at most `farthest` m from its current one. Its ghosts get the
// same bits.
struct Ahead {
  float dt;
  float farthest;

  void of(const float (&x)[3], const float (&v)[3], float (&at)[3]) const {
    float way[3];
    for (int c = 0; c < 3; ++c) way[c] = v[c] * dt;
    const float length2 = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    if (length2 > farthest * farthest) {
      const float part = farthest / std::sqrt(length2);
      for (float& w : way) w *= part;
    }
    for (int c = 0; c < 3; ++c) at[c] = x[c] + way[c];
  }
};

class Interaction {
 public:
  Interaction(const Action& action, const Extent& extent, float dt, const Side (&sides)[2], Scratch& scratch,
              threads::Pool& pool)
      : action_(action), law_(law_of(action)), extent_(extent), dt_(dt), sides_(sides), scratch_(scratch), pool_(pool),
        count_(sides[1].store == nullptr ? 1 : 2), reach_(reach_of(action, extent)) {}

  InteractionCounts act() {
    for (std::size_t s = 0; s < count_; ++s) gather(s);
    InteractionCounts seen;
    if (clear() > 0) {
      for (std::size_t s = 0; s < count_; ++s) seen.dropped[s] = in_the_way(s);
      for (std::size_t s = 0; s < count_; ++s) set_newborn_apart(s);
    }
    for (std::size_t s = 0; s < count_; ++s) {
      run(s, seen);
      seen.most_in_a_cell = std::max(seen.most_in_a_cell, cells(s).most_in_a_cell());
    }
    if (law_.remembers) seen.walls = touch_walls(action_, sides_[0], dt_, walls_view(), pool_);
    if (sides_[0].last && has_radius(action_) && !sides_[0].of_clumps)
      seen.overlap_99 = overlap_99(spheres(0), spheres(count_ - 1));
    for (std::size_t s = 0; s < count_; ++s) apply(s);
    if (sides_[0].last && law_.remembers) list_of(0).write_down(*sides_[0].store, sides_[0].law, sides_[0].now);
    return seen;
  }

  InteractionCounts act_on_pairs(const PairProcedure& procedure) {
    gather(0);
    const float* column[6];
    for (std::size_t c = 0; c < 6; ++c) column[c] = scratch_.party[0].column[c].data();
    const PairList list = pairs_within(reach_, scratch_.party[0].cells, crowds_[0], column, sides_[0].chosen);
    const std::vector<float> changes = procedure(list);
    float* const v[3] = {sides_[0].store->writable_plane(particles::velocity, 0),
                         sides_[0].store->writable_plane(particles::velocity, 1),
                         sides_[0].store->writable_plane(particles::velocity, 2)};
    for (std::size_t k = 0; k < changes.size() / 3; ++k) {
      for (std::size_t c = 0; c < 3; ++c) v[c][list.own[k]] += changes[3 * k + c];
    }
    return {list.size(), scratch_.party[0].cells.most_in_a_cell()};
  }

 private:
  void gather(std::size_t s) {
    const std::vector<Column> columns = columns_of(action_, sides_[s]);
    Scratch::Party& party = scratch_.party[s];
    Crowd& crowd = crowds_[s];
    crowd.own = sides_[s].store->size();
    crowd.own_ids = sides_[s].store->ids();
    if (sides_[s].ghosts != nullptr) {
      crowd.ghosts = sides_[s].ghosts->ids.size();
      crowd.copied_ids = sides_[s].ghosts->ids.data();
    }
    for (std::size_t c = 0; c < 3; ++c) crowd.at[c] = columns[c];
    now_[s] = crowd;
    if (law_.looks_ahead) look_ahead(columns, party, crowd);
    if (!law_.remembers) {
      party.cells.sort(crowd, static_cast<double>(reach_) * (1 + kMargin), pool_);
      return arrange_all(s, columns);
    }
    NeighbourList& list = list_of(s);
    list.set_kind(list_kind(action_, sides_[s]));
    if (!sides_[s].kept) list.sort(crowd, reach_, sides_[s].skin, pool_);
    arrange_all(s, columns);
    if (!sides_[s].kept) list.build(crowd, placed(s), *sides_[s].store, sides_[s].law, sides_[s].now, pool_);
  }

  NeighbourList& list_of(std::size_t s) const {
    return sides_[s].list != nullptr ? *sides_[s].list : scratch_.party[s].list;
  }

  const Cells& cells(std::size_t s) const { return law_.remembers ? list_of(s).cells() : scratch_.party[s].cells; }

  PlacedSpheres placed(std::size_t s) const {
    const auto& column = scratch_.party[s].column;
    return {{column[at_x].data(), column[at_y].data(), column[at_z].data()}, column[radius].data()};
  }

  void arrange_all(std::size_t s, const std::vector<Column>& columns) {
    const std::vector<Component> read = read_by(action_);
    for (std::size_t c = 0; c < 3; ++c) arrange(s, at_x + static_cast<int>(c), crowds_[s].at[c]);
    for (std::size_t number = 3; number < read.size(); ++number) {
      if (const int to = place_of(read[number]); to >= 0) arrange(s, to, columns[number]);
      if (read[number].attribute == particles::size && radii()) arrange_radii(s, columns[number]);
      if (read[number].attribute == particles::mass && masses()) arrange_masses(s, columns[number]);
      if (read[number].attribute == particles::mass && !law_.inverse_masses) arrange_positive(s, mass, columns[number]);
    }
  }

  PlacedParticles walls_view() {
    PlacedParticles placed{&cells(0), {}, {}};
    for (std::size_t c = 0; c < party_columns; ++c) placed.column[c] = scratch_.party[0].column[c].data();
    for (std::size_t c = 0; c < kMostResults; ++c) placed.out[c] = scratch_.party[0].out[c].data();
    return placed;
  }

  // Returns the column for a component that the law reads unchanged; -1: it reads only values derived from it.
  static int place_of(Component read) {
    switch (read.attribute) {
      case particles::velocity: return velocity_x + read.component;
      case particles::rotational_velocity: return spin_x + read.component;
      case particles::contacts: return contacts;
      default: return -1;
    }
  }

  void arrange(std::size_t s, int to, const Column& column) {
    Scratch::Party& party = scratch_.party[s];
    std::vector<float>& values = party.column[to];
    values.resize(padded(crowds_[s].size()));
    cells(s).arrange(crowds_[s], column, values.data(), pool_);
  }

  // Arranges a column; values that are not above 0 become 0.
  void arrange_positive(std::size_t s, int to, const Column& column) {
    arrange(s, to, column);
    std::vector<float>& values = scratch_.party[s].column[to];
    for (std::size_t i = 0; i < crowds_[s].size(); ++i) values[i] = values[i] > 0 ? values[i] : 0.0f;
  }

  void look_ahead(const std::vector<Column>& columns, Scratch::Party& party, Crowd& crowd) {
    const Ahead ahead{dt_, step_limit(reach_)};
    for (std::size_t c = 0; c < 3; ++c) {
      party.at[c].resize(crowd.own);
      party.copied_at[c].resize(crowd.ghosts);
    }
    const auto look = [&](std::size_t i, bool own, std::vector<float>(&to)[3]) {
      float values[6];
      for (std::size_t c = 0; c < 6; ++c) values[c] = columns[c].of(own ? i : i + crowd.own, crowd.own);
      float at[3];
      ahead.of({values[0], values[1], values[2]}, {values[3], values[4], values[5]}, at);
      for (int c = 0; c < 3; ++c) to[c][i] = at[c];
    };
    threads::over_ranges(pool_, crowd.own, kRange, [&](std::size_t first, std::size_t last) {
      const simd::FloatMode mode;
      for (std::size_t i = first; i < last; ++i) look(i, true, party.at);
    });
    for (std::size_t i = 0; i < crowd.ghosts; ++i) look(i, false, party.copied_at);
    for (std::size_t c = 0; c < 3; ++c) crowd.at[c] = {party.at[c].data(), party.copied_at[c].data(), 0};
  }

  bool radii() const {
    if (law_.radius == nullptr) return false;
    return !law_.uniform || given_radius(action_, false) == 0 || (count_ == 2 && given_radius(action_, true) == 0);
  }
  bool masses() const { return law_.inverse_masses && (!law_.uniform || extent_.masses > 0); }
  float clear() const { return law_.clear != nullptr ? law_.clear(action_.numbers.data()) : 0; }

  Spheres spheres(std::size_t s) const {
    const Scratch::Party& party = scratch_.party[s];
    return {&cells(s), &now_[s], radii() ? party.column[radius].data() : nullptr, given_radius(action_, s == 1),
            sides_[s].place != 0};
  }

  float radius_at(std::size_t s, std::size_t place) const {
    return radii() ? scratch_.party[s].column[radius][place] : given_radius(action_, s == 1);
  }

  // Returns newborn particles that overlap others by more than the given part of their radius. Of two newborn particles
  // the one with the higher id, or of the second system, is returned.
  std::vector<std::uint32_t> in_the_way(std::size_t s) const {
    const std::size_t other = count_ == 2 ? 1 - s : s;
    const CellsView own = scratch_.party[s].cells.view(crowds_[s].own);
    const CellsView others = scratch_.party[other].cells.view(crowds_[other].own);
    const auto is_newborn = [&](std::size_t side, std::uint64_t id) { return id >= sides_[side].newborn_from; };
    std::vector<std::uint32_t> found;
    const std::vector<Row>& rows = scratch_.party[s].cells.rows();
    for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
      for (std::uint32_t i = rows[r].first; i < rows[r + 1].first; ++i) {
        const std::uint32_t index = own.order[i];
        if (index >= crowds_[s].own || !is_newborn(s, crowds_[s].id(index))) continue;
        bool hit = false;
        for (const Row* row : rows_around(scratch_.party[other].cells, rows[r].x, rows[r].y)) {
          each_near(others, *row, own.z[i], [&](std::uint32_t j) {
            const std::uint64_t id = crowds_[other].id(others.order[j]);
            const bool yields = !is_newborn(other, id) || (count_ == 2 ? s == 1 : id < crowds_[s].id(index));
            hit = hit || (yields && (count_ == 2 || i != j) && overlaps(s, i, other, j));
          });
        }
        if (hit) found.push_back(index);
      }
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  bool overlaps(std::size_t s, std::size_t i, std::size_t other, std::size_t j) const {
    const auto& own = scratch_.party[s].column;
    const auto& theirs = scratch_.party[other].column;
    float r2 = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float d = theirs[c][j] - own[c][i];
      r2 += d * d;
    }
    const float least = radius_at(s, i) * (1 - clear()) + radius_at(other, j);
    return least > 0 && r2 < least * least;
  }

  // Moves newborn particles to NaN, where they push nothing; whether they stay is decided once all of them are known.
  void set_newborn_apart(std::size_t s) {
    const std::vector<std::uint32_t>& order = scratch_.party[s].cells.order();
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (crowds_[s].id(order[k]) >= sides_[s].newborn_from) {
        scratch_.party[s].column[at_x][k] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }

  void arrange_radii(std::size_t s, const Column& widths) {
    const float given = given_radius(action_, s == 1);
    const Crowd& crowd = crowds_[s];
    std::vector<float>& values = scratch_.party[s].column[radius];
    if (given > 0 && sides_[s].place == 0) {
      values.assign(padded(crowd.size()), given);
      return;
    }
    arrange(s, radius, widths);
    const std::vector<std::uint32_t>& order = cells(s).order();
    for (std::size_t i = 0; i < crowd.size(); ++i)
      values[i] = given > 0 && order[i] < crowd.own ? given : radius_of_size(values[i]);
  }

  // Arranges inverse masses. A particle whose mass is 0 or NaN never pushes others, or has no contacts
  // (Law::skips_massless).
  void arrange_masses(std::size_t s, const Column& all_masses) {
    arrange(s, inverse_mass, all_masses);
    std::vector<float>& values = scratch_.party[s].column[inverse_mass];
    for (std::size_t i = 0; i < crowds_[s].size(); ++i) {
      const bool heavy = values[i] >= kLeastMass;
      if (!heavy && law_.skips_massless) scratch_.party[s].column[radius][i] = 0;
      values[i] = 1 / (heavy ? values[i] : kLeastMass);
    }
  }

  // Runs the law for the targets of one side. Its sources are of the same side or, with two systems, of the other.
  void run(std::size_t s, InteractionCounts& seen) {
    if (law_.prepare != nullptr) {
      run(s, law_.prepare, crowds_[s].size(), seen);
      scratch_.party[s].column[pressure].swap(scratch_.party[s].out[0]);
    }
    run(s, law_.act, crowds_[s].own, seen);
  }

  // Runs a kernel. `target_count`: particles with a lower index are targets.
  void run(std::size_t s, void (*kernel)(const Task&), std::size_t target_count, InteractionCounts& seen) {
    Scratch::Party& party = scratch_.party[s];
    const std::size_t other = count_ == 2 ? 1 - s : s;
    const float* columns[2][party_columns];
    for (std::size_t p = 0; p < count_; ++p) {
      for (std::size_t c = 0; c < party_columns; ++c) columns[p][c] = scratch_.party[p].column[c].data();
    }
    float* out[kMostResults];
    for (std::size_t c = 0; c < changed_.size(); ++c) {
      party.out[c].resize(padded(crowds_[s].size()));
      out[c] = party.out[c].data();
    }
    const Party targets{cells(s).view(target_count), columns[s], &crowds_[s]};
    const Party sources{cells(other).view(crowds_[other].own), columns[other], &crowds_[other]};
    const std::vector<std::size_t> cuts = parts_of(cells(s), pool_);
    std::vector<KernelStats> sights(cuts.size() - 1);
    const PairsView pairs = law_.remembers ? list_of(s).view(sides_[s].now) : PairsView{};
    const std::uint8_t* const chosen = sides_[s].chosen != nullptr ? sides_[s].chosen->data() : nullptr;
    Task task{targets, sources, action_.numbers.data(), reach_, dt_};
    task.fast = 2 * extent_.displacement > step_limit(reach_);  // it is along one axis only
    task.gravity = std::max(sides_[0].gravity, sides_[1].gravity);
    task.side = count_ == 1 ? sides_[0].place : static_cast<int>(s) + 1;
    task.now = sides_[0].now;
    task.radii = radii();
    task.masses = masses();
    task.out = out;
    task.pairs = pairs;
    task.chosen = chosen;
    task.sums_alone = sides_[0].of_clumps;
    pool_.run(sights.size(), [&](std::size_t part, std::size_t) {
      const simd::FloatMode mode;
      Task rows = task;
      rows.first_row = cuts[part];
      rows.last_row = cuts[part + 1];
      rows.stats = &sights[part];
      kernel(rows);
    });
    for (const KernelStats& stats : sights) seen.pairs += stats.pairs;
  }

  void apply(std::size_t s) {
    float* to[kMostResults];
    for (std::size_t c = 0; c < changed_.size(); ++c) {
      to[c] = sides_[s].store->writable_plane(changed_[c].attribute, changed_[c].component);
    }
    const std::vector<std::uint32_t>& order = cells(s).order();
    const std::vector<std::uint8_t>* chosen = sides_[s].chosen;
    const std::vector<std::uint8_t>* adds_to = sides_[s].adds_to;
    threads::over_ranges(pool_, order.size(), kRange, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) {
        const std::uint32_t i = order[k];
        if (i >= crowds_[s].own || (chosen != nullptr && (*chosen)[i] == 0)) continue;
        for (std::size_t c = 0; c < changed_.size(); ++c) {
          const bool counts = changed_[c].attribute == particles::contacts;
          const bool adds = law_.adds || (counts && sides_[s].adds && (adds_to == nullptr || (*adds_to)[i] != 0));
          const float out = scratch_.party[s].out[c][k];
          to[c][i] = adds ? to[c][i] + out : out;
        }
      }
    });
  }

  const Action& action_;
  const Law& law_;
  const std::vector<Component> changed_ = changed_by(action_);
  const Extent& extent_;
  float dt_;
  const Side (&sides_)[2];
  Scratch& scratch_;
  threads::Pool& pool_;
  std::size_t count_;
  float reach_;
  Crowd crowds_[2];
  Crowd now_[2];  // the same particles at their positions before the step
};

}  // namespace

std::vector<Column> columns_of(const Action& action, const Side& side, bool second) {
  std::vector<Column> columns;
  for (const Component c : read_by(action, second)) {
    Column column;
    column.own = side.store->plane(c.attribute, c.component);
    column.value = side.store->uniform_value(c.attribute)[static_cast<std::size_t>(c.component)];
    if (side.ghosts != nullptr && !side.ghosts->ids.empty())
      column.ghosts = side.ghosts->columns[columns.size()].data();
    columns.push_back(column);
  }
  return columns;
}

NeighbourList::Kind list_kind(const Action& action, const Side& side, bool second) {
  if (second) return {.parts = 0};
  if (action.kind != actions::Kind::interact) return {.ghosts_alone = side.place != 0, .of_clumps = side.of_clumps};
  const auto parts = static_cast<std::uint32_t>((actions::states_of(action) + kStateNumbers - 1) / kStateNumbers);
  return {parts, 1, action.partner.has_value()};
}

bool list_holds(const Action& action, const Side& side, bool second, Scratch& scratch, threads::Pool& pool) {
  if (action.kind == actions::Kind::contact_clumps) return clumps_hold(action, side, scratch, pool);
  Crowd own;
  own.own = side.store->size();
  own.own_ids = side.store->ids();
  const std::vector<Component> read = read_by(action);
  const std::vector<Column> columns = columns_of(action, side);
  const auto& position = side.store->uniform_value(particles::position);
  for (int c = 0; c < 3; ++c) {
    const auto number = static_cast<std::size_t>(c);
    own.at[number] = {side.store->plane(particles::position, c), nullptr, position[number]};
  }
  Radii radii;
  radii.given = has_radius(action) ? given_radius(action, false) : 0.5f * reach_of(action, {});
  radii.skips_massless = law_of(action).skips_massless;
  for (std::size_t c = 0; c < read.size(); ++c) {
    if (read[c].attribute == particles::size) radii.size = columns[c];
    if (read[c].attribute == particles::mass) radii.mass = columns[c];
  }
  side.list->set_kind(list_kind(action, side, second));
  return side.list->holds(own, radii, side.now, pool);
}

InteractionCounts act_on_pairs(const Action& action, const Side& side, const PairProcedure& procedure, Scratch& scratch,
                               threads::Pool& pool) {
  if (!(reach_of(action, {}) > 0)) return {};
  const simd::FloatMode mode;
  const Side sides[2] = {side, {}};
  const Extent extent;
  return Interaction(action, extent, 0, sides, scratch, pool).act_on_pairs(procedure);
}

InteractionCounts act(const Action& action, const Extent& extent, float dt, const Side (&sides)[2], Scratch& scratch,
                      threads::Pool& pool) {
  if (action.kind == actions::Kind::contact_clumps) return act_on_clumps(action, extent, dt, sides[0], scratch, pool);
  if (!(reach_of(action, extent) > 0)) return {};
  return Interaction(action, extent, dt, sides, scratch, pool).act();
}

}  // namespace motes::interactions
