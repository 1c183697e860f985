#include "interactions/kinds/sweeping.h"

#include <algorithm>
#include <cmath>

#include "interactions/kinds/families.h"
#include "particles/blocks.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

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

// Returns the column for a component that the law reads unchanged; -1: it reads only values derived from it.
int place_of(Component read) {
  switch (read.attribute) {
    case particles::velocity: return velocity_x + read.component;
    case particles::rotational_velocity: return spin_x + read.component;
    case particles::contacts: return contacts;
    default: return -1;
  }
}

}  // namespace

InteractionCounts Sweeping::act(const Agreement& agreed) {
  extent_ = agreed.extent;
  reach_ = reach(agreed);
  if (!(reach_ > 0)) return {};
  for (std::size_t s = 0; s < meeting_.count; ++s) gather(s);
  InteractionCounts seen;
  prepare(seen);
  for (std::size_t s = 0; s < meeting_.count; ++s) {
    run(s, seen);
    seen.most_in_a_cell = std::max(seen.most_in_a_cell, cells(s).most_in_a_cell());
  }
  finish(seen);
  for (std::size_t s = 0; s < meeting_.count; ++s) apply(s);
  return seen;
}

void Sweeping::gather(std::size_t s) {
  const std::vector<Column> columns = columns_of(read_by(action()), side(s));
  now_[s] = crowds_[s] = crowd_of(side(s), columns);
  if (law_.looks_ahead) look_ahead(s, columns);
  party(s).cells.sort(crowds_[s], static_cast<double>(reach_) * (1 + kMargin), *meeting_.pool);
  arrange_all(s, columns);
}

void Sweeping::arrange_all(std::size_t s, const std::vector<Column>& columns) {
  const std::vector<Component> read = read_by(action());
  for (std::size_t c = 0; c < 3; ++c) arrange(s, at_x + static_cast<int>(c), crowds_[s].at[c]);
  for (std::size_t number = 3; number < read.size(); ++number) {
    if (const int to = place_of(read[number]); to >= 0) arrange(s, to, columns[number]);
    if (read[number].attribute == particles::size && radii()) arrange_radii(s, columns[number]);
    if (read[number].attribute == particles::mass && masses()) arrange_masses(s, columns[number]);
    if (read[number].attribute == particles::mass && !law_.inverse_masses) arrange_positive(s, mass, columns[number]);
  }
}

void Sweeping::arrange(std::size_t s, int to, const Column& column) {
  std::vector<float>& values = party(s).column[to];
  values.resize(padded(crowds_[s].size()));
  cells(s).arrange(crowds_[s], column, values.data(), *meeting_.pool);
}

// Arranges a column; values that are not above 0 become 0.
void Sweeping::arrange_positive(std::size_t s, int to, const Column& column) {
  arrange(s, to, column);
  std::vector<float>& values = party(s).column[to];
  for (std::size_t i = 0; i < crowds_[s].size(); ++i) values[i] = values[i] > 0 ? values[i] : 0.0f;
}

void Sweeping::arrange_radii(std::size_t s, const Column& sizes) {
  const float given = given_radius(action(), s == 1);
  const std::size_t count = crowds_[s].size();
  std::vector<float>& values = party(s).column[radius];
  if (given > 0) {
    values.assign(padded(count), given);
    return;
  }
  arrange(s, radius, sizes);
  for (std::size_t i = 0; i < count; ++i) values[i] = radius_of_size(values[i]);
}

// Arranges inverse masses. A particle whose mass is 0 or NaN never pushes others.
void Sweeping::arrange_masses(std::size_t s, const Column& masses) {
  arrange(s, inverse_mass, masses);
  std::vector<float>& values = party(s).column[inverse_mass];
  for (std::size_t i = 0; i < crowds_[s].size(); ++i) {
    values[i] = 1 / (values[i] >= kLeastMass ? values[i] : kLeastMass);
  }
}

void Sweeping::look_ahead(std::size_t s, const std::vector<Column>& columns) {
  Crowd& crowd = crowds_[s];
  Scratch::Party& memory = party(s);
  const Ahead ahead{meeting_.step.dt, step_limit(reach_)};
  for (std::size_t c = 0; c < 3; ++c) {
    memory.at[c].resize(crowd.own);
    memory.copied_at[c].resize(crowd.ghosts);
  }
  const auto look = [&](std::size_t i, bool own, std::vector<float>(&to)[3]) {
    float values[6];
    for (std::size_t c = 0; c < 6; ++c) values[c] = columns[c].of(own ? i : i + crowd.own, crowd.own);
    float at[3];
    ahead.of({values[0], values[1], values[2]}, {values[3], values[4], values[5]}, at);
    for (int c = 0; c < 3; ++c) to[c][i] = at[c];
  };
  threads::over_ranges(*meeting_.pool, crowd.own, kRange, [&](std::size_t first, std::size_t last) {
    const simd::FloatMode mode;
    for (std::size_t i = first; i < last; ++i) look(i, true, memory.at);
  });
  for (std::size_t i = 0; i < crowd.ghosts; ++i) look(i, false, memory.copied_at);
  for (std::size_t c = 0; c < 3; ++c) crowd.at[c] = {memory.at[c].data(), memory.copied_at[c].data(), 0};
}

bool Sweeping::radii() const {
  if (law_.radius == nullptr) return false;
  return !law_.uniform || given_radius(action(), false) == 0 ||
         (meeting_.count == 2 && given_radius(action(), true) == 0);
}

Spheres Sweeping::spheres(std::size_t s) const {
  return {&cells(s), &now_[s], radii() ? party(s).column[radius].data() : nullptr, given_radius(action(), s == 1)};
}

float Sweeping::overlaps() const { return overlap_99(spheres(0), spheres(seen_by(0))); }

// Runs the law for the targets of one side. Its sources are of the same side or, with two systems, of the other.
void Sweeping::run(std::size_t s, InteractionCounts& seen) {
  if (law_.prepare != nullptr) {
    run(s, law_.prepare, crowds_[s].size(), seen);
    party(s).column[pressure].swap(party(s).out[0]);
  }
  run(s, law_.act, crowds_[s].own, seen);
}

// Runs a kernel. `target_count`: particles with a lower index are targets.
void Sweeping::run(std::size_t s, void (*kernel)(const Task&), std::size_t target_count, InteractionCounts& seen) {
  const std::size_t other = seen_by(s);
  const float* columns[2][party_columns];
  for (std::size_t p = 0; p < meeting_.count; ++p) {
    for (std::size_t c = 0; c < party_columns; ++c) columns[p][c] = party(p).column[c].data();
  }
  float* out[kMostResults];
  for (std::size_t c = 0; c < changed_.size(); ++c) {
    party(s).out[c].resize(padded(crowds_[s].size()));
    out[c] = party(s).out[c].data();
  }
  const Party targets{cells(s).view(target_count), columns[s], &crowds_[s]};
  const Party sources{cells(other).view(crowds_[other].own), columns[other], &crowds_[other]};
  const std::vector<std::size_t> cuts = parts_of(cells(s), *meeting_.pool);
  std::vector<KernelStats> sights(cuts.size() - 1);
  Task task{targets, sources, action().numbers.data(), reach_, meeting_.step.dt};
  task.radii = radii();
  task.masses = masses();
  task.out = out;
  describe(s, task);
  meeting_.pool->run(sights.size(), [&](std::size_t part, std::size_t) {
    const simd::FloatMode mode;
    Task rows = task;
    rows.first_row = cuts[part];
    rows.last_row = cuts[part + 1];
    rows.stats = &sights[part];
    kernel(rows);
  });
  for (const KernelStats& stats : sights) seen.pairs += stats.pairs;
}

void Sweeping::describe(std::size_t s, Task& task) const {
  task.side = meeting_.count == 1 ? 0 : static_cast<int>(s) + 1;
}

void Sweeping::apply(std::size_t s) const {
  float* to[kMostResults];
  for (std::size_t c = 0; c < changed_.size(); ++c)
    to[c] = side(s).store->writable_plane(changed_[c].attribute, changed_[c].component);
  const Scratch::Party& memory = party(s);
  const std::vector<std::uint32_t>& order = cells(s).order();
  const std::vector<std::uint8_t>* chosen = side(s).chosen;
  const Collisions& before = side(s).collisions;
  const std::size_t own = crowds_[s].own;
  threads::over_ranges(*meeting_.pool, order.size(), kRange, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const std::uint32_t i = order[k];
      if (i >= own || (chosen != nullptr && (*chosen)[i] == 0)) continue;
      for (std::size_t c = 0; c < changed_.size(); ++c) {
        const bool counts = changed_[c].attribute == particles::contacts;
        const bool adds = law_.adds || (counts && before.adds_for(i));
        const float out = memory.out[c][k];
        to[c][i] = adds ? to[c][i] + out : out;
      }
    }
  });
}

namespace families {

std::unique_ptr<PairAction> sweeping(const Meeting& meeting) { return std::make_unique<Sweeping>(meeting); }

}  // namespace families

}  // namespace motes::interactions
