#include "interactions/kinds/sphere_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "interactions/walls.h"

namespace motes::interactions {

namespace {

// The images, across the ends of periodic space, of those particles that others within range of them may see.
struct SeenImages {
  std::vector<std::uint32_t> originals;
  std::vector<float> at[3];

  SeenImages(const Crowd& crowd, const particles::Periods& periods, float range, bool of_ghosts) {
    if (!periods.any() || crowd.own == 0) return;
    float low[3], high[3];
    for (int c = 0; c < 3; ++c) find_bounds(crowd, c, range, low[c], high[c]);
    for (std::size_t i = of_ghosts ? crowd.own : 0; i < crowd.size(); ++i) {
      float x[3], places[3][3];
      int count[3];
      for (int c = 0; c < 3; ++c) {
        const auto a = static_cast<std::size_t>(c);
        x[c] = crowd.at[a].of(i, crowd.own);
        places[c][0] = x[c];
        count[c] = 1;
        for (const double way : {1.0, -1.0}) {
          if (!periods.has(c)) continue;
          const auto image = static_cast<float>(static_cast<double>(x[c]) + way * periods[c].length());
          if (image >= low[c] && image <= high[c]) places[c][count[c]++] = image;
        }
      }
      for (int n = 1; n < count[0] * count[1] * count[2]; ++n) {
        const int part[3] = {n % count[0], n / count[0] % count[1], n / count[0] / count[1]};
        originals.push_back(static_cast<std::uint32_t>(i));
        for (std::size_t c = 0; c < 3; ++c) at[c].push_back(places[c][part[c]]);
      }
    }
  }

 private:
  static void find_bounds(const Crowd& crowd, int axis, float range, float& low, float& high) {
    low = std::numeric_limits<float>::infinity();
    high = -low;
    for (std::size_t i = 0; i < crowd.own; ++i) {
      const float x = crowd.at[axis].of(i, crowd.own);
      low = std::min(low, x);
      high = std::max(high, x);
    }
    low = std::nextafter(low - range, -std::numeric_limits<float>::infinity());
    high = std::nextafter(high + range, std::numeric_limits<float>::infinity());
  }
};

}  // namespace

InteractionCounts SphereSweep::act(const Agreement& agreed) {
  const float reach = this->reach(agreed);
  if (!(reach > 0)) return {};
  const std::vector<Column> columns = columns_of(read_by(action()), side(0));
  const Crowd crowd = crowd_of(side(0), columns);
  const GrainColumns grains = columns_of_grains(columns);
  list_.set_kind(grouping_.kind());
  if (kept_.holds) {
    place(crowd, grains);
  } else {
    build(crowd, grains, reach);
  }
  InteractionCounts seen;
  seen.pairs = near().act(task(), reach, list_.cells(), *meeting_.pool);
  seen.most_in_a_cell = list_.cells().most_in_a_cell();
  seen.walls = touch_walls(side(0), meeting_.step, {&list_.cells(), near().grains(), near().out()}, *meeting_.pool);
  if (meeting_.step.last) {
    if (!grouping_.of_clumps) seen.overlap_99 = near().overlap_99(list_.cells(), crowd.own, ends_);
    list_.write_down(*side(0).store, kept_.law, meeting_.step.number);
  }
  apply(crowd.own);
  return seen;
}

GrainColumns SphereSweep::columns_of_grains(const std::vector<Column>& columns) const {
  GrainColumns grains;
  for (std::size_t c = 0; c < 3; ++c) {
    grains.at[c] = columns[sphere_x + c];
    grains.velocity[c] = columns[sphere_velocity + c];
    grains.spin[c] = columns[sphere_spin + c];
  }
  grains.size = columns[sphere_size];
  grains.mass = columns[sphere_mass];
  grains.given = given_radius(action(), false);
  grains.given_own = grouping_.place != 0;
  return grains;
}

void SphereSweep::place(const Crowd& crowd, const GrainColumns& grains) {
  near().place({list_.cells(), grains, crowd.own, crowd.ghosts, ends_}, *meeting_.pool);
}

void SphereSweep::build(const Crowd& crowd, const GrainColumns& grains, float reach) {
  const SeenImages images(crowd, *meeting_.periods, (reach + kept_.skin) * 1.001f, grouping_.place != 0);
  Crowd all = crowd;
  std::vector<float> at[3];
  std::vector<std::uint64_t> ids;
  if (!images.originals.empty()) {
    for (std::size_t c = 0; c < 3; ++c) {
      at[c].assign(crowd.at[c].ghosts, crowd.at[c].ghosts + crowd.ghosts);
      at[c].insert(at[c].end(), images.at[c].begin(), images.at[c].end());
      all.at[c].ghosts = at[c].data();
    }
    ids.assign(crowd.copied_ids, crowd.copied_ids + crowd.ghosts);
    for (const std::uint32_t i : images.originals) ids.push_back(crowd.id(i));
    all.copied_ids = ids.data();
    all.ghosts = ids.size();
  }
  list_.sort(all, reach, kept_.skin, *meeting_.pool);
  near().forget();
  place(crowd, grains);
  std::vector<float> columns[4];
  const std::vector<std::uint32_t>& order = list_.cells().order();
  for (std::vector<float>& column : columns) column.resize(padded(order.size()));
  const auto place_of = images.originals.empty() ? std::vector<std::uint32_t>() : list_.cells().places();
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool image = order[k] >= crowd.size();
    const std::size_t number = image ? order[k] - crowd.size() : 0;
    const Grain& grain = near().grains()[image ? place_of[images.originals[number]] : k];
    for (std::size_t c = 0; c < 3; ++c) columns[c][k] = image ? images.at[c][number] : grain.at[c];
    columns[3][k] = grain.radius;
  }
  list_.build(all, {{columns[0].data(), columns[1].data(), columns[2].data()}, columns[3].data()}, *side(0).store,
              kept_.law, meeting_.step.number, *meeting_.pool, images.originals);
}

TouchTask SphereSweep::task() {
  TouchTask task = list_.touches(meeting_.step.number);
  task.numbers = action().numbers.data();
  task.dt = meeting_.step.dt;
  task.side = grouping_.place;
  task.ends = &ends_;
  task.chosen = side(0).chosen != nullptr ? side(0).chosen->data() : nullptr;
  task.sums_alone = grouping_.of_clumps;
  return task;
}

void SphereSweep::apply(std::size_t own) {
  const std::vector<Component> changed = changed_by(action());
  const Collisions& before = side(0).collisions;
  GiveTask task;
  task.out = near().out();
  task.order = list_.cells().order().data();
  task.own = static_cast<std::uint32_t>(own);
  task.chosen = side(0).chosen != nullptr ? side(0).chosen->data() : nullptr;
  for (std::size_t c = 0; c < changed.size(); ++c)
    task.to[c] = side(0).store->writable_plane(changed[c].attribute, changed[c].component);
  task.adds = before.adds;
  if (before.adds && before.adds_to != nullptr) task.adds_to = before.adds_to->data();
  threads::over_ranges(*meeting_.pool, list_.cells().size(), kRange, [&](std::size_t first, std::size_t last) {
    GiveTask range = task;
    range.from = static_cast<std::uint32_t>(first);
    range.last = static_cast<std::uint32_t>(last);
    near().kernels().give_pushes(range);
  });
}

}  // namespace motes::interactions
