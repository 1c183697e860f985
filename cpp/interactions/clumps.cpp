#include "interactions/clumps.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using actions::Action;
using particles::Touch;

const particles::Schema& schema_of_spheres() {
  static const particles::Schema schema;
  return schema;
}

// Returns the contact action of a system's spheres. The numbers of contact_clumps begin with those of contact.
Action contact_of_spheres(const Action& clumps) {
  if (clumps.kind == actions::Kind::contact) return clumps;
  Action action{actions::Kind::contact, {}, clumps.shapes, {}, clumps.specifics, clumps.partner};
  std::get<actions::Grains>(action.specifics).clump = 0;
  action.numbers.assign(clumps.numbers.begin(),
                        clumps.numbers.begin() + sizeof(actions::numbers::contact<double>) / sizeof(double));
  action.numbers[0] = 0;  // each sphere has its own radius
  return action;
}

// Inverts a symmetric tensor (xx, yy, zz, xy, xz, yz).
void invert(const double (&t)[6], double (&to)[6]) {
  const double xx = t[1] * t[2] - t[5] * t[5], xy = t[4] * t[5] - t[3] * t[2], xz = t[3] * t[5] - t[4] * t[1];
  const double part = 1 / (t[0] * xx + t[3] * xy + t[4] * xz);
  const double inverse[6] = {xx, t[0] * t[2] - t[4] * t[4], t[0] * t[1] - t[3] * t[3], xy,
                             xz, t[3] * t[4] - t[0] * t[5]};
  for (int i = 0; i < 6; ++i) to[i] = inverse[i] * part;
}

// Runs a kernel over ranges of `count` clumps.
void over_clumps(const ClumpTask& task, std::size_t count, void (*kernel)(const ClumpTask&), threads::Pool& pool) {
  threads::over_ranges(pool, count, kRange, [&](std::size_t first, std::size_t last) {
    const simd::FloatMode mode;
    ClumpTask range = task;
    range.first = first;
    range.last = last;
    kernel(range);
  });
}

// Returns the ids of all spheres: sphere k of clump i is at k * count + i.
template <class CopiedIds>
std::vector<std::uint64_t> ids_of_spheres(const CopiedIds& clumps, std::size_t count, std::size_t parts) {
  std::vector<std::uint64_t> ids;
  ids.reserve(count * parts);
  for (std::size_t k = 0; k < parts; ++k) {
    for (std::size_t i = 0; i < count; ++i) ids.push_back(sphere_id(clumps[i], k));
  }
  return ids;
}

}  // namespace

// Columns of clumps, readable to the end of the last vector.
class ClumpColumns {
 public:
  // Copies the columns of a side's own clumps or of its ghosts.
  ClumpColumns(const Action& action, const Side& side, bool ghosts)
      : count_(!ghosts                  ? side.store->size()
               : side.ghosts != nullptr ? side.ghosts->ids.size()
                                        : 0) {
    const std::vector<Column> columns = columns_of(action, side);
    for (std::size_t c = 0; c < clump_columns; ++c) {
      values_[c].assign(count_ + particles::kPadding, columns[c].value);
      const float* const from = ghosts ? columns[c].ghosts : columns[c].own;
      if (from != nullptr) std::copy_n(from, count_, values_[c].begin());
      columns_[c] = values_[c].data();
    }
  }
  ClumpColumns(const ClumpColumns&) = delete;
  ClumpColumns& operator=(const ClumpColumns&) = delete;

  std::size_t count() const { return count_; }

  ClumpTask task(const std::vector<ClumpSphere>& spheres) const {
    ClumpTask task;
    task.column = columns_;
    task.spheres = spheres.data();
    task.count = spheres.size();
    task.stride = count_;
    return task;
  }

  // Writes the SphereAt columns of the spheres.
  void place(const std::vector<ClumpSphere>& spheres, float* const* placed, threads::Pool& pool) const {
    ClumpTask task = this->task(spheres);
    task.placed = placed;
    over_clumps(task, count_, kernels().place_spheres, pool);
  }

 private:
  std::size_t count_;
  std::vector<float> values_[clump_columns];
  const float* columns_[clump_columns] = {};
};

// The spheres of all clumps that a rank knows, as particles. Sphere k of the i-th of n clumps is at k * n + i.
class ExpandedClumps {
 public:
  // Expands a side's own clumps.
  ExpandedClumps(const Action& action, const Side& side, threads::Pool& pool)
      : law_(contact_of_spheres(action)), template_(spheres_of(actions::grains_of(action)->clump)),
        columns_(action, side, false) {
    const std::size_t count = columns_.count() * template_.size();
    store_.grow(count);
    store_.set_ids(0, ids_of_spheres(side.store->ids(), columns_.count(), template_.size()));
    const std::vector<Component> read = read_by(law_);
    float* placed[sphere_columns];
    for (std::size_t c = 0; c < sphere_columns; ++c)
      placed[c] = store_.writable_plane(read[c].attribute, read[c].component);
    columns_.place(template_, placed, pool);
  }

  const Action& law() const { return law_; }
  const std::vector<ClumpSphere>& spheres() const { return template_; }
  particles::Store& store() { return store_; }
  ClumpTask task() const { return columns_.task(template_); }

  // Adds the spheres of ghosts.
  void expand_ghosts(const Action& action, const Side& side, threads::Pool& pool) {
    const ClumpColumns columns(action, side, true);
    if (columns.count() > 0) ghosts_.ids = ids_of_spheres(side.ghosts->ids, columns.count(), template_.size());
    ghosts_.columns.assign(sphere_columns, std::vector<float>(ghosts_.ids.size()));
    float* placed[sphere_columns];
    for (std::size_t c = 0; c < sphere_columns; ++c) placed[c] = ghosts_.columns[c].data();
    columns.place(template_, placed, pool);
  }

  // Returns the spheres as a side of contact.
  Side side(const Side& clumps) {
    Side spheres = clumps;
    spheres.store = &store_;
    spheres.ghosts = &ghosts_;
    spheres.of_clumps = true;
    if (clumps.chosen == nullptr) return spheres;
    for (std::size_t k = 0; k < template_.size(); ++k)
      chosen_.insert(chosen_.end(), clumps.chosen->begin(), clumps.chosen->end());
    spheres.chosen = &chosen_;
    return spheres;
  }

  // Copies the touches of each clump to its spheres, except those of pairs in a kept list, which holds their states.
  void remember(const Side& clumps) {
    const auto needed = [&](const Touch& touch) {
      return particles::law_of(touch) == clumps.law && (!clumps.kept || (touch.law & particles::kWall) != 0);
    };
    std::vector<Touch> touches;
    const std::size_t own = columns_.count();
    for (std::size_t i = 0; i < own && clumps.store->remembers(); ++i) {
      const std::span<const Touch> all = clumps.store->touches(i);
      if (std::none_of(all.begin(), all.end(), needed)) continue;
      for (std::size_t k = 0; k < template_.size(); ++k) {
        touches.clear();
        for (const Touch& touch : all) {
          if (!needed(touch) || particles::part_of(touch) != k) continue;
          touches.push_back(touch);
          touches.back().law = clumps.law | (touch.law & particles::kWall);
        }
        if (!touches.empty()) store_.set_touches(k * own + i, touches);
      }
    }
  }

 private:
  Action law_;
  std::vector<ClumpSphere> template_;
  ClumpColumns columns_;
  particles::Store store_{schema_of_spheres()};
  Ghosts ghosts_;
  std::vector<std::uint8_t> chosen_;
};

namespace {

// Writes the touches of the spheres to the store: those with walls and, in a frame's last sub-step, those with each
// other, which only the list holds until then.
void take_touches(const Side& side, const particles::Store& spheres, std::size_t parts) {
  particles::Store& store = *side.store;
  if (!spheres.remembers() && !store.remembers()) return;
  std::vector<Touch> touches;
  const auto replaced = [&](const Touch& touch) { return side.last || (touch.law & particles::kWall) != 0; };
  for (std::size_t i = 0; i < store.size(); ++i) {
    touches.clear();
    bool changes = false;
    for (const Touch& touch : store.touches(i)) {
      const bool stays = particles::law_of(touch) != side.law || !replaced(touch);
      if (stays) touches.push_back(touch);
      changes = changes || !stays;
    }
    for (std::size_t k = 0; k < parts; ++k) {
      for (const Touch& touch : spheres.touches(k * store.size() + i)) {
        if (touch.step != side.now || !replaced(touch)) continue;
        touches.push_back(touch);
        touches.back().law = particles::law_part(touch.law, static_cast<std::uint32_t>(k));
        changes = true;
      }
    }
    if (changes) store.set_touches(i, touches);
  }
}

// Sums the pushes on the spheres onto their clumps.
class Summing {
 public:
  Summing(const Action& action, float dt, const Side& side, const ExpandedClumps& spheres, threads::Pool& pool)
      : side_(side), task_(spheres.task()), pool_(pool) {
    task_.dt = dt;
    const auto given = actions::numbers_of<actions::numbers::contact_clumps>(action);
    double tensor[6], inverse[6];
    for (int c = 0; c < 3; ++c) {
      tensor[c] = given.moments[c];
      tensor[3 + c] = given.products[c];
    }
    invert(tensor, inverse);
    for (int n = 0; n < 6; ++n) {
      task_.inertia[n] = static_cast<float>(tensor[n]);
      task_.inverse[n] = static_cast<float>(inverse[n]);
    }
  }

  // Moves the clumps. `sums`: changes of velocity and spin, and contacts, of the spheres.
  void run(const float* const (&sums)[7]) {
    const std::size_t count = side_.store->size();
    std::vector<float> turned(count + particles::kPadding, side_.adds ? 1.0f : 0.0f);
    if (side_.adds && side_.adds_to != nullptr) std::copy_n(side_.adds_to->begin(), count, turned.begin());
    task_.turned = turned.data();
    float* out[7];
    for (int c = 0; c < 7; ++c) {
      out_[c].resize(count);
      out[c] = out_[c].data();
    }
    task_.sums = sums;
    task_.out = out;
    over_clumps(task_, count, kernels().turn_clumps, pool_);
    for (int c = 0; c < 3; ++c) {
      put(particles::velocity, c, out_[c], false);
      put(particles::spin, c, out_[3 + c], false);
    }
    put(particles::contacts, 0, out_[6], side_.adds);
  }

 private:
  void put(int attribute, int component, const std::vector<float>& values, bool adds) const {
    float* to = side_.store->writable_plane(attribute, component);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (side_.chosen != nullptr && (*side_.chosen)[i] == 0) continue;
      to[i] = adds && (side_.adds_to == nullptr || (*side_.adds_to)[i] != 0) ? to[i] + values[i] : values[i];
    }
  }

  const Side& side_;
  ClumpTask task_;
  threads::Pool& pool_;
  std::vector<float> out_[7];
};

}  // namespace

std::vector<ClumpSphere> spheres_of(actions::TableKey key) {
  const std::shared_ptr<const actions::LookupTable> table = actions::table(key);
  std::vector<ClumpSphere> spheres(table->values.size() / 4);
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    const float* const numbers = table->values.data() + 4 * k;
    spheres[k] = {{numbers[0], numbers[1], numbers[2]}, numbers[3]};
  }
  return spheres;
}

void place_spheres(const particles::Store& store, const std::vector<ClumpSphere>& spheres, float* const* placed,
                   threads::Pool& pool) {
  Action action;
  action.kind = actions::Kind::contact_clumps;
  Side side;
  side.store = const_cast<particles::Store*>(&store);  // NOLINT(cppcoreguidelines-pro-type-const-cast): only read
  ClumpColumns(action, side, false).place(spheres, placed, pool);
}

float bounding_radius(const std::vector<ClumpSphere>& spheres) {
  double most = 0;
  for (const ClumpSphere& sphere : spheres) {
    double square = 0;
    for (const float x : sphere.at) square += double{x} * double{x};
    most = std::max(most, std::sqrt(square) + double{sphere.radius});
  }
  return static_cast<float>(most * (1 + 1e-6));
}

namespace {

// The spheres of one system during a contact: its particles themselves, or those of its clumps.
class ContactSide {
 public:
  ContactSide(const Action& action, const Side& given, Scratch& scratch, threads::Pool& pool)
      : action_(action), given_(given), pool_(pool), law_(contact_of_spheres(action)), side_(given) {
    if (action.kind == actions::Kind::contact) return;
    if (!given.kept || scratch.clumps == nullptr)
      scratch.clumps = std::make_shared<ExpandedClumps>(action, given, pool);
    clumps_ = std::move(scratch.clumps);
    clumps_->expand_ghosts(action, given, pool);
    clumps_->remember(given);
    side_ = clumps_->side(given);
  }

  const Side& side() const { return side_; }

  // Returns the largest radius of a sphere, m. `radius`: that of the particles, or of the balls that enclose clumps.
  float radius_of_spheres(float radius) const {
    if (clumps_ == nullptr) return radius;
    float largest = 0;
    for (const ClumpSphere& sphere : clumps_->spheres()) largest = std::max(largest, sphere.radius);
    return radius * (largest / bounding_radius(clumps_->spheres())) * 1.00001f;
  }

  // Returns the side with all spheres of another system as ghosts. `place`: see Side.
  Side side(const Ghosts& others, int place) const {
    Side seeing = side_;
    seeing.ghosts = &others;
    seeing.place = place;
    return seeing;
  }

  // Returns all spheres, ghosts included, as another system sees them.
  Ghosts all() const {
    const Store& store = *side_.store;
    Ghosts all;
    for (std::size_t i = 0; i < store.size(); ++i) all.ids.push_back(store.ids()[i]);
    if (side_.ghosts != nullptr) all.ids.insert(all.ids.end(), side_.ghosts->ids.begin(), side_.ghosts->ids.end());
    for (const Column& column : columns_of(law_, side_)) {
      std::vector<float>& values = all.columns.emplace_back(all.ids.size());
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = column.of(i, store.size());
    }
    const float radius = given_radius(law_, false);
    if (radius > 0) std::fill(all.columns[sphere_size].begin(), all.columns[sphere_size].end(), 2 * radius);
    return all;
  }

  // Lets the side's spheres touch each other or its ghosts, and sums the pushes on spheres onto their clumps.
  InteractionCounts act(const Side& side, const Extent& extent, float dt, Scratch& scratch) {
    const bool reaches = reach_of(law_, extent) > 0;
    const Side sides[2] = {side, {}};
    const InteractionCounts seen = interactions::act(law_, extent, dt, sides, scratch, pool_);
    if (clumps_ == nullptr) return seen;
    Store& store = *side.store;
    const float* sums[7];
    for (int c = 0; c < 6; ++c) {
      float* const sum = store.writable_plane(c < 3 ? particles::velocity : particles::rotational_velocity, c % 3);
      if (!reaches) std::fill_n(sum, store.size(), 0.0f);  // no sphere has a size, so none is pushed
      sums[c] = sum;
    }
    sums[6] = store.writable_plane(particles::contacts, 0);
    Summing(action_, dt, given_, *clumps_, pool_).run(sums);
    take_touches(given_, store, clumps_->spheres().size());
    return seen;
  }

 private:
  using Store = particles::Store;

  const Action& action_;
  const Side& given_;
  threads::Pool& pool_;
  Action law_;
  Side side_;
  std::shared_ptr<ExpandedClumps> clumps_;  // null: particles are spheres
};

}  // namespace

InteractionCounts act_on_clumps(const Action& action, const Extent& extent, float dt, const Side& side,
                                Scratch& scratch, threads::Pool& pool) {
  const simd::FloatMode mode;
  ContactSide clumps(action, side, scratch, pool);
  Extent of_spheres = extent;
  of_spheres.radius = clumps.radius_of_spheres(extent.radius);
  return clumps.act(clumps.side(), of_spheres, dt, scratch);
}

InteractionCounts contact_between(const Action* const (&actions)[2], const Extent& extent, float dt,
                                  const Side (&sides)[2], Scratch& scratch, threads::Pool& pool) {
  const simd::FloatMode mode;
  ContactSide first(*actions[0], sides[0], scratch.of(0), pool);
  ContactSide second(*actions[1], sides[1], scratch.of(1), pool);
  Extent of_spheres = extent;
  of_spheres.radius = first.radius_of_spheres(extent.radius);
  of_spheres.other_radius = second.radius_of_spheres(extent.other_radius);
  const Ghosts seen_by_first = second.all(), seen_by_second = first.all();  // before either changes
  InteractionCounts seen = first.act(first.side(seen_by_first, 1), of_spheres, dt, scratch.of(0));
  const InteractionCounts more = second.act(second.side(seen_by_second, 2), of_spheres, dt, scratch.of(1));
  seen.pairs += more.pairs;
  seen.most_in_a_cell = std::max(seen.most_in_a_cell, more.most_in_a_cell);
  seen.overlap_99 = std::max(seen.overlap_99, more.overlap_99);
  return seen;
}

bool clumps_hold(const Action& action, const Side& side, Scratch& scratch, threads::Pool& pool) {
  scratch.clumps = std::make_shared<ExpandedClumps>(action, side, pool);
  return list_holds(scratch.clumps->law(), scratch.clumps->side(side), false, scratch, pool);
}

}  // namespace motes::interactions
