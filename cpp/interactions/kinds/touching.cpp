// contact: grains that touch each other and walls. Grains are spheres, or clumps of spheres. In each sub-step a clump's
// spheres are expanded into particles that touch others by the law of contact, and the pushes on them are summed onto
// the clump. The touches of the spheres travel with the clump: a Touch's part is the number of its sphere.
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "interactions/clumps.h"
#include "interactions/kinds/families.h"
#include "interactions/kinds/sphere_sweep.h"
#include "interactions/scratch.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using actions::Action;
using particles::Touch;

const particles::Schema& schema_of_spheres() {
  static const particles::Schema schema;
  return schema;
}

// Returns the contact of the spheres of clumps. The numbers of contact_clumps begin with those of contact.
Action contact_of_spheres(const Action& clumps) {
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

// The spheres of all clumps that a rank knows, as particles. Sphere k of the i-th of n clumps is at k * n + i.
class ExpandedClumps {
 public:
  // Expands a side's own clumps.
  ExpandedClumps(const Side& side, threads::Pool& pool)
      : law_(contact_of_spheres(*side.action)), template_(spheres_of(actions::grains_of(*side.action)->clump)),
        columns_(side, false) {
    const std::size_t count = columns_.count() * template_.size();
    store_.grow(count);
    store_.set_ids(0, ids_of_spheres(side.store->ids(), columns_.count(), template_.size()));
    const std::vector<Component> read = read_by(law_);
    float* placed[sphere_columns];
    for (std::size_t c = 0; c < sphere_columns; ++c)
      placed[c] = store_.writable_plane(read[c].attribute, read[c].component);
    columns_.place(template_, placed, pool);
  }

  const std::vector<ClumpSphere>& spheres() const { return template_; }
  ClumpTask task() const { return columns_.task(template_); }

  // Adds the spheres of ghosts.
  void expand_ghosts(const Side& side, threads::Pool& pool) {
    const ClumpColumns columns(side, true);
    if (columns.count() > 0) ghosts_.ids = ids_of_spheres(side.ghosts->ids, columns.count(), template_.size());
    ghosts_.columns.assign(sphere_columns, std::vector<float>(ghosts_.ids.size()));
    float* placed[sphere_columns];
    for (std::size_t c = 0; c < sphere_columns; ++c) placed[c] = ghosts_.columns[c].data();
    columns.place(template_, placed, pool);
  }

  // Returns the spheres as a side of contact.
  Side side(const Side& clumps) {
    Side spheres = clumps;
    spheres.action = &law_;
    spheres.store = &store_;
    spheres.ghosts = &ghosts_;
    if (clumps.chosen == nullptr) return spheres;
    for (std::size_t k = 0; k < template_.size(); ++k)
      chosen_.insert(chosen_.end(), clumps.chosen->begin(), clumps.chosen->end());
    spheres.chosen = &chosen_;
    return spheres;
  }

  // Copies the touches of each clump to its spheres, except those of pairs in a kept list, which holds their states.
  void remember(const Side& clumps) {
    const auto needed = [&](const Touch& touch) {
      return particles::law_of(touch) == clumps.kept.law && (!clumps.kept.holds || (touch.law & particles::kWall) != 0);
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
          touches.back().law = clumps.kept.law | (touch.law & particles::kWall);
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

// Writes the touches of the spheres to the store: those with walls and, in a frame's last sub-step, those with each
// other, which only the list holds until then.
void take_touches(const Side& side, const SubStep& step, const particles::Store& spheres, std::size_t parts) {
  particles::Store& store = *side.store;
  if (!spheres.remembers() && !store.remembers()) return;
  std::vector<Touch> touches;
  const auto replaced = [&](const Touch& touch) { return step.last || (touch.law & particles::kWall) != 0; };
  for (std::size_t i = 0; i < store.size(); ++i) {
    touches.clear();
    bool changes = false;
    for (const Touch& touch : store.touches(i)) {
      const bool stays = particles::law_of(touch) != side.kept.law || !replaced(touch);
      if (stays) touches.push_back(touch);
      changes = changes || !stays;
    }
    for (std::size_t k = 0; k < parts; ++k) {
      for (const Touch& touch : spheres.touches(k * store.size() + i)) {
        if (touch.step != step.number || !replaced(touch)) continue;
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
  Summing(const Side& side, float dt, const ExpandedClumps& spheres, threads::Pool& pool)
      : side_(side), task_(spheres.task()), pool_(pool) {
    task_.dt = dt;
    const auto given = actions::numbers_of<actions::numbers::contact_clumps>(*side.action);
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
    std::vector<float> turned(count + particles::kPadding, before_.adds ? 1.0f : 0.0f);
    if (before_.adds && before_.adds_to != nullptr) std::copy_n(before_.adds_to->begin(), count, turned.begin());
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
    put(particles::contacts, 0, out_[6], true);
  }

 private:
  void put(int attribute, int component, const std::vector<float>& values, bool adds) const {
    float* to = side_.store->writable_plane(attribute, component);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (side_.chosen != nullptr && (*side_.chosen)[i] == 0) continue;
      to[i] = adds && before_.adds_for(i) ? to[i] + values[i] : values[i];
    }
  }

  const Side& side_;
  const Collisions& before_ = side_.collisions;
  ClumpTask task_;
  threads::Pool& pool_;
  std::vector<float> out_[7];
};

// The spheres of one system during a contact: its particles themselves, or those of its clumps.
class SphereSide {
 public:
  // `expanded`: the clumps as they were when their list was found to hold.
  SphereSide(const Meeting& meeting, std::size_t s, std::unique_ptr<ExpandedClumps> expanded)
      : given_(meeting.sides[s]), clumps_(std::move(expanded)), spheres_(meeting) {
    spheres_.count = 1;
    spheres_.sides[0] = given_;
    spheres_.scratch = &meeting.scratch->of(s);
    grouping_.of_clumps = actions::grains_of(*given_.action)->clump != 0;
    grouping_.chosen = !given_.action->where.empty();
    if (!grouping_.of_clumps) return;
    if (!given_.kept.holds || clumps_ == nullptr) clumps_ = std::make_unique<ExpandedClumps>(given_, *meeting.pool);
    clumps_->expand_ghosts(given_, *meeting.pool);
    clumps_->remember(given_);
    spheres_.sides[0] = clumps_->side(given_);
  }

  // Scales the largest radius of the particles, m, or of the balls that enclose clumps, to that of a sphere.
  void scale(float& radius) const {
    if (clumps_ == nullptr) return;
    float largest = 0;
    for (const ClumpSphere& sphere : clumps_->spheres()) largest = std::max(largest, sphere.radius);
    radius = radius * (largest / bounding_radius(clumps_->spheres())) * 1.00001f;
  }

  // Returns all spheres, ghosts included, as another system sees them.
  Ghosts all() const {
    const Side& side = spheres_.sides[0];
    const Store& store = *side.store;
    Ghosts all;
    for (std::size_t i = 0; i < store.size(); ++i) all.ids.push_back(store.ids()[i]);
    if (side.ghosts != nullptr) all.ids.insert(all.ids.end(), side.ghosts->ids.begin(), side.ghosts->ids.end());
    for (const Column& column : columns_of(read_by(*side.action), side)) {
      std::vector<float>& values = all.columns.emplace_back(all.ids.size());
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = column.of(i, store.size());
    }
    const float radius = given_radius(*side.action, false);
    if (radius > 0) std::fill(all.columns[sphere_size].begin(), all.columns[sphere_size].end(), 2 * radius);
    return all;
  }

  // Lets the spheres see all spheres of another system instead of their own. `place`: see Grouping.
  void see(const Ghosts& others, int place) {
    spheres_.sides[0].ghosts = &others;
    grouping_.place = place;
  }

  // Lets the spheres touch each other or their ghosts, and sums the pushes on spheres onto their clumps.
  InteractionCounts act(const Agreement& agreed) {
    SphereSweep sweep(spheres_, grouping_);
    const bool reaches = sweep.reach(agreed) > 0;
    InteractionCounts seen = sweep.act(agreed);
    if (clumps_ == nullptr) return seen;
    Store& store = *spheres_.sides[0].store;
    const float* sums[7];
    for (int c = 0; c < 6; ++c) {
      float* const sum = store.writable_plane(c < 3 ? particles::velocity : particles::rotational_velocity, c % 3);
      if (!reaches) std::fill_n(sum, store.size(), 0.0f);  // no sphere has a size, so none is pushed
      sums[c] = sum;
    }
    sums[6] = store.writable_plane(particles::contacts, 0);
    Summing(given_, spheres_.step.dt, *clumps_, *spheres_.pool).run(sums);
    take_touches(given_, spheres_.step, store, clumps_->spheres().size());
    return seen;
  }

 private:
  using Store = particles::Store;

  const Side& given_;
  std::unique_ptr<ExpandedClumps> clumps_;  // null: particles are spheres
  Meeting spheres_;
  Grouping grouping_;
};

class Touching : public PairAction {
 public:
  explicit Touching(const Meeting& meeting) : PairAction(meeting) {}

  AcrossEnds across_ends() const override { return AcrossEnds::nearest; }

  // Clumps reach as far as the balls that enclose them.
  Agreement own() override {
    Agreement own = PairAction::own();
    for (std::size_t s = 0; s < meeting_.count; ++s) {
      if (clump(s) == 0) continue;
      float& radius = s == 0 ? own.extent.radius : own.extent.other_radius;
      radius *= 2 * bounding_radius(spheres_of(clump(s)));  // so far, half of the size
    }
    return own;
  }

  bool holds(std::size_t s) override {
    Side spheres = side(s);
    if (clump(s) != 0) {
      expanded_[s] = std::make_unique<ExpandedClumps>(side(s), *meeting_.pool);
      spheres = expanded_[s]->side(side(s));
    }
    const Grouping grouping{clump(s) != 0, !action(s).where.empty(), meeting_.count == 1 ? 0 : static_cast<int>(s) + 1};
    const std::vector<Column> columns = columns_of(read_by(*spheres.action), spheres);
    const Radii radii{given_radius(*spheres.action, false), columns[sphere_size], columns[sphere_mass],
                      law_of(*spheres.action).skips_massless};
    return list_holds(spheres, grouping.kind(), radii, meeting_, *meeting_.periods);
  }

  InteractionCounts act(const Agreement& agreed) override {
    const simd::FloatMode mode;
    Agreement of_spheres = agreed;
    SphereSide first(meeting_, 0, std::move(expanded_[0]));
    first.scale(of_spheres.extent.radius);
    if (meeting_.count == 1) return first.act(of_spheres);
    SphereSide second(meeting_, 1, std::move(expanded_[1]));
    second.scale(of_spheres.extent.other_radius);
    const Ghosts seen_by_first = second.all(), seen_by_second = first.all();  // before either changes
    first.see(seen_by_first, 1);
    second.see(seen_by_second, 2);
    InteractionCounts seen = first.act(of_spheres);
    const InteractionCounts more = second.act(of_spheres);
    seen.pairs += more.pairs;
    seen.most_in_a_cell = std::max(seen.most_in_a_cell, more.most_in_a_cell);
    seen.overlap_99 = std::max(seen.overlap_99, more.overlap_99);
    return seen;
  }

  float substeps(const Agreement& agreed, double frame_s) const override {
    float most = 0;
    for (std::size_t s = 0; s < meeting_.count; ++s) most = std::max(most, substeps_of(action(s), agreed, frame_s));
    return most;
  }

 private:
  actions::TableKey clump(std::size_t s) const { return actions::grains_of(action(s))->clump; }

  static float substeps_of(const Action& action, const Agreement& agreed, double frame_s) {
    double lightness = agreed.extent.masses > 0 ? static_cast<double>(agreed.extent.masses) : 1;
    if (actions::grains_of(action)->clump != 0)
      lightness *= actions::numbers_of<actions::numbers::contact_clumps>(action).lightness;
    double stiffest = 2 * actions::contact_of(action).stiffness;  // for half of the mass
    for (const actions::WallNumbers& wall : actions::grains_of(action)->walls)
      stiffest = std::max(stiffest, wall.stiffness);
    return static_cast<float>(std::ceil(frame_s * std::sqrt(lightness * (stiffest / double{kMostStiff}))));
  }

  std::unique_ptr<ExpandedClumps> expanded_[2];  // if the particles are clumps, once holds() has been asked
};

}  // namespace

std::unique_ptr<PairAction> families::touching(const Meeting& meeting) { return std::make_unique<Touching>(meeting); }

}  // namespace motes::interactions
