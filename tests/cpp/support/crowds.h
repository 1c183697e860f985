// Crowds of particles for tests of the laws between them, and all builds of the kernels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "actions/action.h"
#include "interactions/cell_list.h"
#include "interactions/extent.h"
#include "interactions/kernels.h"
#include "interactions/neighbour_list.h"
#include "particles/blocks.h"
#include "particles/ids.h"
#include "particles/store.h"
#include "simd/declare_builds.h"
#include "simd/float_mode.h"
#include "support/isas.h"
#include "threads/pool.h"

MOTES_DECLARE_BUILDS(motes::interactions::Kernels, interaction_kernels)

namespace test {

namespace interactions = motes::interactions;

struct MeetingBuild {
  std::string name;
  const interactions::Kernels& kernels;
};

/// Returns the builds that this process can run, narrowest first.
inline const std::vector<MeetingBuild>& meeting_builds() {
  static const std::vector<MeetingBuild> all = [] {
    std::vector<MeetingBuild> found;
    const auto kernels = runnable<interactions::Kernels>(MOTES_BUILDS(interaction_kernels));
    const std::vector<Build> all_builds = builds();
    for (std::size_t i = 0; i < kernels.size(); ++i) found.push_back({all_builds[i].name, *kernels[i]});
    return found;
  }();
  return all;
}

template <class T>
void shuffle(std::vector<T>& values, Dice& dice) {
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[dice.below(i)]);
}

inline std::vector<std::uint64_t> numbers(std::size_t count, std::uint64_t first) {
  std::vector<std::uint64_t> all(count);
  std::iota(all.begin(), all.end(), first);
  return all;
}

/// Particles by index: this rank's own, then ghosts of others.
struct Flock {
  std::array<std::vector<float>, interactions::party_columns> column;
  std::vector<std::uint64_t> ids;
  std::size_t own = 0;

  std::size_t size() const { return ids.size(); }
  interactions::Column plane(std::size_t c) const { return {column[c].data(), column[c].data() + own, 0}; }
  motes::particles::IdList own_ids() const { return motes::particles::IdList(std::span(ids).first(own)); }
  /// Returns the crowd, which refers to own_ids(): the caller must keep them.
  interactions::Crowd crowd(const motes::particles::IdList& own_ids) const {
    return {{plane(0), plane(1), plane(2)}, own_ids, ids.data() + own, own, size() - own};
  }
};

/// Returns particles in a cube around the origin, with ids in random order; reaches are below 0.25 m, contacts as in a
/// pile.
inline Flock random_flock(std::size_t count, float half, std::uint64_t seed) {
  Dice dice(seed);
  Flock flock;
  flock.own = count;
  flock.ids = numbers(count, 5);
  shuffle(flock.ids, dice);
  for (std::size_t c = 0; c < interactions::party_columns; ++c) {
    for (std::size_t i = 0; i < count; ++i) {
      float value = c < interactions::velocity_x ? dice.between(-half, half) : dice.between(-2, 2);
      if (c == interactions::contacts) value = static_cast<float>(dice.below(9));
      if (c == interactions::radius) value = dice.between(0.05f, 0.125f);
      if (c == interactions::inverse_mass) value = 1 / dice.between(0.25f, 4);
      if (c == interactions::mass) value = 1 / flock.column[interactions::inverse_mass][i];
      flock.column[c].push_back(value);
    }
  }
  return flock;
}

/// Returns the particles at these indices; the first `own` are this rank's.
inline Flock taken(const Flock& from, const std::vector<std::size_t>& indices, std::size_t own) {
  Flock flock;
  flock.own = own;
  for (const std::size_t i : indices) {
    flock.ids.push_back(from.ids[i]);
    for (std::size_t c = 0; c < interactions::party_columns; ++c) flock.column[c].push_back(from.column[c][i]);
  }
  return flock;
}

/// An action and the settings that its law runs with. Tests of a new law set the first three.
struct Law {
  motes::actions::Action action;
  float reach = 0, step = 1.0f / 256;
  bool radii = false, masses = false;
  int side = 0;
  std::uint32_t now = 7;
  bool skin = false;  // contact: whether its list has one

  std::vector<interactions::Component> outputs() const { return interactions::changed_by(action); }
};

namespace given = motes::actions::numbers;
using motes::actions::make;

inline Law gravitation(float reach) {
  return {make(given::gravitate<>{.magnitude = 5.12, .epsilon = 1e-3, .max_radius = double{reach}}), reach};
}

/// `strength`: magnitude times the step.
inline Law matching(float reach, float strength) {
  return {
      make(given::match_velocity<>{.magnitude = double{strength} * 256, .epsilon = 0.5, .max_radius = double{reach}}),
      reach};
}

inline Law collision(float reach, double restitution, bool radii, bool masses) {
  return {make(given::collide<>{.restitution = restitution, .friction = 0.5}), reach, 1.0f / 256, radii, masses};
}

/// `reach`: that of two particles with the largest radius.
inline Law contact_law(float reach, double stiffness = 2000) {
  return {make(given::contact<>{.restitution = 0.5, .friction = 0.5, .stiffness = stiffness, .rolling_friction = 0.25}),
          reach, 1.0f / 256, true, true};
}

inline Law fluid_law(float reach, double rest_density = 300, double viscosity = 1e-3, double cohesion = 2) {
  return {make(given::fluid<>{
              .rest_density = rest_density, .viscosity = viscosity, .radius = double{reach}, .cohesion = cohesion}),
          reach, 1.0f / 256, false, true};
}

/// Returns each law, some with several settings, for tests of all laws.
inline const std::vector<Law>& all_laws() {
  static const std::vector<Law> all = [] {
    std::vector<Law> made{gravitation(0.25f), matching(0.25f, 1e-3f), matching(0.25f, 0.3f), contact_law(0.25f),
                          fluid_law(0.25f)};
    for (const bool radii : {false, true}) {
      for (const bool masses : {false, true}) {
        made.push_back(collision(0.25f, 0, radii, masses));
        made.push_back(collision(0.25f, 0.6f, radii, masses));
      }
    }
    return made;
  }();
  return all;
}

/// What own particles remember of their contacts, by index.
using Remembered = std::vector<std::vector<motes::particles::Touch>>;

/// What a law computes for each own particle, by index.
struct Heard {
  std::array<std::vector<float>, interactions::kMostResults> out;
  Remembered touches;
  std::uint64_t pairs = 0;
};

/// A flock in the order of its cells, as kernels expect it.
struct Arranged {
  Arranged(const Flock& flock, float reach, motes::threads::Pool& pool)
      : own_ids(flock.own_ids()), crowd(flock.crowd(own_ids)) {
    cells.sort(crowd, static_cast<double>(reach) * (1 + 1e-6), pool);
    arrange(flock, pool);
  }
  void arrange(const Flock& flock, motes::threads::Pool& pool) {
    for (std::size_t c = 0; c < interactions::party_columns; ++c) {
      column[c].resize(flock.size() + 2 * motes::particles::kPadding);
      cells.arrange(crowd, flock.plane(c), column[c].data(), pool);
      planes[c] = column[c].data();
    }
  }
  interactions::Party party() const { return {cells.view(crowd.own), planes, &crowd}; }

  motes::particles::IdList own_ids;
  interactions::Crowd crowd;
  interactions::Cells cells;
  std::vector<float> column[interactions::party_columns];
  const float* planes[interactions::party_columns];
};

/// Lists the pairs of a flock and puts it in the list's order. `touches`: what the particles remember.
inline interactions::NeighbourList listed(const MeetingBuild& build, const Law& law, const Flock& flock,
                                          Arranged& arranged, const Remembered& touches, motes::threads::Pool& pool) {
  static const motes::particles::Schema schema;
  motes::particles::Store store(schema);
  store.grow(flock.own);
  for (std::size_t i = 0; i < flock.own; ++i) store.set_touches(i, touches[i]);
  interactions::NeighbourList list(build.kernels);
  list.set_kind({.near = true});
  list.sort(arranged.crowd, law.reach, law.skin ? 0.1f * law.reach : 0, pool);
  arranged.cells = list.cells();
  arranged.arrange(flock, pool);
  const float* const* plane = arranged.planes;
  list.build(arranged.crowd, {{plane[0], plane[1], plane[2]}, plane[interactions::radius]}, store, 0, law.now, pool);
  return list;
}

/// Lets the grains of a list touch each other.
inline Heard touched(interactions::NeighbourList& list, const Law& law, const Flock& flock,
                     motes::threads::Pool& pool) {
  std::vector<float> size = flock.column[interactions::radius], mass = flock.column[interactions::mass];
  for (float& diameter : size) diameter *= 2;
  for (std::vector<float>* values : {&size, &mass}) values->resize(values->size() + motes::particles::kPadding);
  const auto column = [&](const std::vector<float>& values) {
    return interactions::Column{values.data(), values.data() + flock.own, 0};
  };
  interactions::GrainColumns columns;
  for (std::size_t c = 0; c < 3; ++c) {
    columns.at[c] = flock.plane(interactions::at_x + c);
    columns.velocity[c] = flock.plane(interactions::velocity_x + c);
    columns.spin[c] = flock.plane(interactions::spin_x + c);
  }
  columns.size = column(size);
  columns.mass = column(mass);
  const interactions::Ends ends({});
  list.near().place({list.cells(), columns, flock.own, flock.size() - flock.own, ends}, pool);
  interactions::TouchTask task = list.touches(law.now);
  task.numbers = law.action.numbers.data();
  task.dt = law.step;
  task.side = law.side;
  task.ends = &ends;
  Heard heard;
  heard.pairs = list.near().act(task, law.reach, list.cells(), pool);
  heard.touches.resize(flock.own);
  for (std::vector<float>& out : heard.out) out.resize(flock.own);
  for (std::size_t k = 0; k < flock.size(); ++k) {
    const std::uint32_t i = list.cells().order()[k];
    if (i >= flock.own) continue;
    const interactions::GrainPush& push = list.near().out()[k];
    for (std::size_t c = 0; c < 3; ++c) {
      heard.out[c][i] = push.velocity[c];
      heard.out[3 + c][i] = push.spin[c];
    }
    heard.out[6][i] = push.touches;
    list.recall(k, 0, heard.touches[i]);
  }
  return heard;
}

/// Runs a law. `sources`: the particles that the targets see; `touches`: what the targets remember.
inline Heard heard(const MeetingBuild& build, const Law& law, const Flock& targets, const Flock& sources,
                   motes::threads::Pool& pool = motes::threads::alone(), Remembered touches = {}) {
  touches.resize(targets.own);
  if (law.action.kind == motes::actions::Kind::contact) {
    Arranged arranged(targets, law.reach, pool);
    interactions::NeighbourList list = listed(build, law, targets, arranged, touches, pool);
    return touched(list, law, targets, pool);
  }
  const interactions::Law& known = build.kernels.law[static_cast<std::size_t>(law.action.kind)];
  Arranged seeing(targets, law.reach, pool);
  Arranged seen(sources, law.reach, pool);
  std::vector<float> by_place[interactions::kMostResults];
  float* out[interactions::kMostResults];
  for (std::size_t c = 0; c < interactions::kMostResults; ++c) {
    by_place[c].resize(targets.size() + 2 * motes::particles::kPadding);
    out[c] = by_place[c].data();
  }
  const std::size_t rows = seeing.cells.rows().size() - 1;
  const std::size_t parts = pool.threads() == 1 ? 1 : 5;
  std::vector<interactions::KernelStats> parts_seen(parts);
  const auto run = [&](void (*law_kernel)(const interactions::Task&), interactions::Party seers) {
    pool.run(parts, [&](std::size_t part, std::size_t) {
      const motes::simd::FloatMode mode;
      interactions::Task task{seers, seen.party(), law.action.numbers.data(), law.reach, law.step, law.side};
      task.radii = law.radii;
      task.masses = law.masses;
      task.out = out;
      task.first_row = rows * part / parts;
      task.last_row = rows * (part + 1) / parts;
      task.stats = &parts_seen[part];
      law_kernel(task);
    });
  };
  if (known.prepare != nullptr) {
    interactions::Party all = seeing.party();
    all.cells = seeing.cells.view(targets.size());
    run(known.prepare, all);
    for (Arranged* arranged : {&seeing, &seen}) {
      arranged->column[interactions::pressure] = by_place[0];
      arranged->planes[interactions::pressure] = arranged->column[interactions::pressure].data();
    }
  }
  run(known.act, seeing.party());
  Heard heard;
  for (std::size_t c = 0; c < law.outputs().size(); ++c) {
    heard.out[c].resize(targets.own);
    for (std::size_t k = 0; k < targets.size(); ++k) {
      const std::uint32_t i = seeing.cells.order()[k];
      if (i < targets.own) heard.out[c][i] = by_place[c][k];
    }
  }
  for (const interactions::KernelStats& seen : parts_seen) heard.pairs += seen.pairs;
  heard.touches.resize(targets.own);
  return heard;
}

inline Heard heard(const MeetingBuild& build, const Law& law, const Flock& flock,
                   motes::threads::Pool& pool = motes::threads::alone()) {
  return heard(build, law, flock, flock, pool);
}

}  // namespace test
