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

// The law of the spheres: contact, whose numbers come first.
Action contact_of_spheres(const Action& clumps) {
  Action action;
  action.kind = actions::Kind::contact;
  action.numbers.assign(clumps.numbers.begin(),
                        clumps.numbers.begin() + sizeof(actions::numbers::contact<double>) / sizeof(double));
  action.numbers[0] = 0;  // each sphere has a radius of its own
  action.shapes = clumps.shapes;
  return action;
}

// The inverse of a symmetric tensor (xx, yy, zz, xy, xz, yz).
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

// The columns of a side's clumps: own ones, then ghosts, readable to the end of the last vector.
class ClumpColumns {
 public:
  ClumpColumns(const Action& action, const Side& side) {
    const std::size_t own = side.store->size(), ghosts = side.ghosts != nullptr ? side.ghosts->ids.size() : 0;
    const std::vector<Column> columns = columns_of(action, side);
    for (std::size_t c = 0; c < clump_columns; ++c) {
      values_[c].assign(own + ghosts + 2 * particles::kPadding, columns[c].value);
      if (columns[c].own != nullptr) std::copy_n(columns[c].own, own, values_[c].begin());
      if (ghosts > 0) std::copy_n(columns[c].ghosts, ghosts, values_[c].begin() + static_cast<std::ptrdiff_t>(own));
      columns_[c] = values_[c].data();
    }
  }

  const float* const* data() const { return columns_; }

  // Writes where the spheres of the clumps from `first` on are, of which there are `count`.
  void place(const std::vector<ClumpSphere>& spheres, std::size_t first, std::size_t count, float* const* placed,
             threads::Pool& pool) const {
    const float* from[clump_columns];
    for (std::size_t c = 0; c < clump_columns; ++c) from[c] = columns_[c] + first;
    ClumpTask task;
    task.column = from;
    task.spheres = spheres.data();
    task.count = spheres.size();
    task.stride = count;
    task.placed = placed;
    over_clumps(task, count, kernels().place_spheres, pool);
  }

 private:
  std::vector<float> values_[clump_columns];
  const float* columns_[clump_columns] = {};
};

// The spheres of all clumps that a rank knows, as particles. Sphere k of the i-th of n stands at k * n + i.
class Expansion {
 public:
  Expansion(const Action& action, const Side& side, threads::Pool& pool)
      : side_(side), law_(contact_of_spheres(action)), template_(spheres_of(action.table)), own_(side.store->size()),
        ghosts_(side.ghosts != nullptr ? side.ghosts->ids.size() : 0), pool_(pool), columns_(action, side) {
    place_own();
    place_ghosts();
    if (side.chosen == nullptr) return;
    for (std::size_t k = 0; k < template_.size(); ++k)
      chosen_.insert(chosen_.end(), side.chosen->begin(), side.chosen->end());
  }

  const Action& law() const { return law_; }
  const std::vector<ClumpSphere>& spheres() const { return template_; }
  particles::Store& store() { return store_; }

  /// The spheres as a side of contact.
  Side side() {
    Side spheres = side_;
    spheres.store = &store_;
    spheres.ghosts = &copies_;
    spheres.chosen = side_.chosen != nullptr ? &chosen_ : nullptr;
    spheres.of_clumps = true;
    return spheres;
  }

  /// Gives each sphere what its clump remembers for it. What pairs remember that stay listed is in their list.
  void remember() {
    std::vector<Touch> touches;
    for (std::size_t i = 0; i < own_ && side_.store->remembers(); ++i) {
      const std::span<const Touch> all = side_.store->touches(i);
      for (std::size_t k = 0; k < template_.size() && !all.empty(); ++k) {
        touches.clear();
        for (const Touch& touch : all) {
          const bool wall = (touch.law & particles::kWall) != 0;
          if (particles::law_of(touch) != side_.law || particles::part_of(touch) != k || (side_.kept && !wall))
            continue;
          touches.push_back(touch);
          touches.back().law = side_.law | (wall ? particles::kWall : 0);
        }
        if (!touches.empty()) store_.set_touches(k * own_ + i, touches);
      }
    }
  }

  ClumpTask task() const {
    ClumpTask task;
    task.column = columns_.data();
    task.spheres = template_.data();
    task.count = template_.size();
    return task;
  }

 private:
  void place_own() {
    const std::size_t count = own_ * template_.size();
    store_.grow(count);
    std::vector<std::uint64_t> ids(count);
    for (std::size_t n = 0; n < count; ++n) ids[n] = sphere_id(side_.store->ids()[n % own_], n / own_);
    store_.set_ids(0, ids);
    const std::vector<Component> read = read_by(law_);
    float* placed[sphere_columns];
    for (std::size_t c = 0; c < sphere_columns; ++c) {
      placed[c] = store_.writable_plane(read[c].attribute, read[c].component);
    }
    columns_.place(template_, 0, own_, placed, pool_);
  }

  void place_ghosts() {
    const std::size_t count = ghosts_ * template_.size();
    copies_.ids.resize(count);
    for (std::size_t n = 0; n < count; ++n) copies_.ids[n] = sphere_id(side_.ghosts->ids[n % ghosts_], n / ghosts_);
    copies_.columns.assign(sphere_columns, std::vector<float>(count));
    float* placed[sphere_columns];
    for (std::size_t c = 0; c < sphere_columns; ++c) placed[c] = copies_.columns[c].data();
    columns_.place(template_, own_, ghosts_, placed, pool_);
  }

  const Side& side_;
  Action law_;
  std::vector<ClumpSphere> template_;
  std::size_t own_, ghosts_;
  threads::Pool& pool_;
  ClumpColumns columns_;
  particles::Store store_{schema_of_spheres()};
  Ghosts copies_;
  std::vector<std::uint8_t> chosen_;
};

// Writes to the store what the spheres remember: of walls, and in a frame's last sub-step of each other. Until then
// that is in the list.
void take_touches(const Side& side, const particles::Store& spheres, std::size_t parts) {
  particles::Store& store = *side.store;
  if (!spheres.remembers() && !store.remembers()) return;
  std::vector<Touch> touches;
  for (std::size_t i = 0; i < store.size(); ++i) {
    touches.clear();
    const auto replaced = [&](const Touch& touch) { return side.last || (touch.law & particles::kWall) != 0; };
    for (const Touch& touch : store.touches(i)) {
      if (particles::law_of(touch) != side.law || !replaced(touch)) touches.push_back(touch);
    }
    for (std::size_t k = 0; k < parts; ++k) {
      for (const Touch& touch : spheres.touches(k * store.size() + i)) {
        if (touch.step != side.now || !replaced(touch)) continue;
        touches.push_back(touch);
        touches.back().law = particles::law_part(touch.law, static_cast<std::uint32_t>(k));
      }
    }
    if (!touches.empty() || !store.touches(i).empty()) store.set_touches(i, touches);
  }
}

// Sums what pushes the spheres onto their clumps.
class Summing {
 public:
  Summing(const Action& action, float dt, const Side& side, Expansion& spheres, threads::Pool& pool)
      : side_(side), task_(spheres.task()), pool_(pool) {
    task_.dt = dt;
    task_.stride = side.store->size();
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

  // `sums`: velocities, spins and contacts of the spheres.
  void run(const float* const (&sums)[7]) {
    const std::size_t count = side_.store->size();
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
  const std::shared_ptr<const actions::Table> table = actions::table(key);
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
  side.store = const_cast<particles::Store*>(&store);  // NOLINT(cppcoreguidelines-pro-type-const-cast): read alone
  ClumpColumns(action, side).place(spheres, 0, store.size(), placed, pool);
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

Seen act_on_clumps(const Action& action, const Extent& extent, float dt, const Side& side, Scratch& scratch,
                   threads::Pool& pool) {
  const simd::FloatMode mode;
  Expansion spheres(action, side, pool);
  spheres.remember();
  float largest = 0;
  for (const ClumpSphere& sphere : spheres.spheres()) largest = std::max(largest, sphere.radius);
  Extent of_spheres = extent;
  of_spheres.radius = extent.radius * (largest / bounding_radius(spheres.spheres())) * 1.00001f;
  const Side sides[2] = {spheres.side(), {}};
  particles::Store& store = spheres.store();
  if (!(of_spheres.radius > 0)) {  // nobody has a size: nobody is pushed
    for (int c = 0; c < 3; ++c) {
      std::fill_n(store.writable_plane(particles::velocity, c), store.size(), 0.0f);
      std::fill_n(store.writable_plane(particles::rotational_velocity, c), store.size(), 0.0f);
    }
  }
  const Seen seen = act(spheres.law(), of_spheres, dt, sides, scratch, pool);
  const float* sums[7];
  for (int c = 0; c < 3; ++c) {
    sums[c] = store.writable_plane(particles::velocity, c);
    sums[3 + c] = store.writable_plane(particles::rotational_velocity, c);
  }
  sums[6] = store.writable_plane(particles::contacts, 0);
  Summing(action, dt, side, spheres, pool).run(sums);
  take_touches(side, store, spheres.spheres().size());
  return seen;
}

bool clumps_hold(const Action& action, const Side& side, threads::Pool& pool) {
  Expansion spheres(action, side, pool);
  return list_holds(spheres.law(), spheres.side(), pool);
}

}  // namespace motes::interactions
