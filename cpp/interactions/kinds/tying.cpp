#include "interactions/kinds/tying.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/invalid_argument.h"
#include "interactions/kinds/families.h"
#include "interactions/scratch.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using particles::Store;

constexpr float kRelaxation = 1.8f;  // factor on the mean of a particle's corrections, where stable
// Upper bound on the corrected part q of an error: with velocities derived from positions, oscillations grow if q >
// 4/3.
constexpr float kStable = 1.3f;
constexpr float kLightest = 0x1p-126f;  // kg; what has no mass counts as this: its inverse can still be added
// Cosine of the angle by which a tie turns so far in a step that its predicted direction says little.
constexpr float kTurned = 0.9f;
constexpr float kInf = std::numeric_limits<float>::infinity();

struct Terms {
  float dt;
  std::array<float, 3> compliance;  // compliance / dt^2 by kind, m/(N s2)
  float undamped;  // part of the relative velocity that damping leaves
  float break_at;
  bool tethers;
};

TiesKey key_of(const actions::Action& action) { return std::get<actions::TiedPairs>(action.specifics).ties; }

double break_at_of(const actions::Action& action) {
  return actions::numbers_of<actions::numbers::tie>(action).break_at;
}

Terms terms_of(const actions::Action& action, float dt) {
  const auto given = actions::numbers_of<actions::numbers::tie, float>(action);
  Terms terms;
  terms.dt = dt;
  terms.compliance = {given.stretch / (dt * dt), given.shear / (dt * dt), given.bend / (dt * dt)};
  terms.undamped = 1 / (1 + given.damping * dt);
  terms.break_at = given.break_at;
  terms.tethers = given.tethers != 0;
  return terms;
}

// Sum of n n^T over the directions n of a particle's ties: how much of a deviation they correct together. That is more
// if all point the same way, as in a rope, than if they share the work, as in a cloth.
struct Spread {
  float xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  void add(const std::array<float, 3>& d, float weight) {
    xx += weight * d[0] * d[0];
    yy += weight * d[1] * d[1];
    zz += weight * d[2] * d[2];
    xy += weight * d[0] * d[1];
    xz += weight * d[0] * d[2];
    yz += weight * d[1] * d[2];
  }

  // Returns an upper bound on the largest eigenvalue.
  float most() const {
    const float x = xx + std::abs(xy) + std::abs(xz);
    const float y = yy + std::abs(xy) + std::abs(yz);
    const float z = zz + std::abs(xz) + std::abs(yz);
    return std::max({x, y, z});
  }
};

float dot(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

float length(const std::array<float, 3>& v) { return std::sqrt(dot(v, v)); }

// Returns the squared distance of two positions, or of one and the nearest image of the other, m2.
float distance2(const float (&a)[3], const float (&b)[3], const particles::Periods& periods) {
  float sum = 0;
  for (int c = 0; c < 3; ++c) {
    const float way = periods.shortest(c, a[c] - b[c]);
    sum += way * way;
  }
  return sum;
}

// Returns positions (x, y, z) of all pinned particles; -infinity for those of other ranks.
std::vector<float> pins_of(const Bonds& bonds, const Store& store) {
  std::vector<float> pins(3 * bonds.pins(), -kInf);
  for (std::size_t i = 0; bonds.pins() > 0 && i < store.size(); ++i) {
    const std::uint32_t row = bonds.row_of(store.ids()[i]);
    if (row == Bonds::kNone || bonds.pin(row) == Bonds::kNone) continue;
    for (int c = 0; c < 3; ++c) {
      pins[3 * bonds.pin(row) + static_cast<std::size_t>(c)] = store.value(particles::position, c, i);
    }
  }
  return pins;
}

class Tying : public PairAction {
 public:
  explicit Tying(const Meeting& meeting) : PairAction(meeting) {}

  // Distant ends must find each other, so ranks agree on the longest tie at the last interaction and on how far its
  // ends may have moved since. Where the pinned particles are, all ranks must know.
  Agreement own() override {
    Agreement own;
    own.more = pins_of(bonds_, *side(0).store);
    if (!meeting_.all_here) stretch(own.extent.radius, own.extent.displacement);
    return own;
  }
  float reach(const Agreement& agreed) const override { return agreed.extent.radius + 2 * agreed.extent.displacement; }
  double range(const Agreement& agreed) const override {
    return static_cast<double>(reach(agreed)) * (1 + 1e-5) + 4 * static_cast<double>(agreed.extent.rounding);
  }
  AcrossEnds across_ends() const override { return AcrossEnds::nearest_partners; }
  std::vector<std::uint32_t> sources(std::size_t s, std::vector<std::uint32_t> particles) const override {
    const particles::Ids ids = side(s).store->ids();
    std::erase_if(particles, [&](std::uint32_t p) { return bonds_.row_of(ids[p]) == Bonds::kNone; });
    return particles;
  }

  InteractionCounts act(const Agreement& agreed) override {
    pins_ = &agreed.more;
    columns_ = columns_of(reads(0), side(0));
    own_ = side(0).store->size();
    count_ = own_ + (side(0).ghosts == nullptr ? 0 : side(0).ghosts->ids.size());
    note_knots();
    return {pull_all(), 0};
  }

 private:
  // Sets the longest tie at the last interaction, and the largest distance travelled since, m; infinite if unknown.
  void stretch(float& longest, float& way) const {
    const Store& store = *side(0).store;
    longest = knots_.longest;
    float farthest2 = 0;
    for (std::size_t i = 0; i < store.size(); ++i) {
      const std::uint32_t row = bonds_.row_of(store.ids()[i]);
      if (row == Bonds::kNone) continue;
      float now[3];
      for (int c = 0; c < 3; ++c) now[c] = store.value(particles::position, c, i);
      if (std::isnan(now[0] + now[1] + now[2])) continue;  // a particle at NaN has no effect
      const bool met = row < knots_.knots.size() && knots_.meeting > 0 && knots_.knots[row].seen == knots_.meeting;
      const float way2 = met ? distance2(now, knots_.knots[row].place, periods_) : kInf;
      farthest2 = way2 <= farthest2 ? farthest2
                  : way2 < kInf     ? way2
                                    : kInf;  // NaN: its last position was NaN, so the displacement is infinite
    }
    way = std::sqrt(farthest2);
  }

  std::uint64_t id(std::size_t i) const { return i < own_ ? side(0).store->ids()[i] : side(0).ghosts->ids[i - own_]; }

  void note_knots() {
    if (knots_.knots.size() != bonds_.rows()) knots_ = {std::vector<Knots::Knot>(bonds_.rows()), 0};
    if (++knots_.meeting == 0) knots_ = {std::vector<Knots::Knot>(bonds_.rows()), 1};
    rows_.resize(own_);
    threads::over_ranges(*meeting_.pool, count_, kRange, [&](std::size_t first, std::size_t last) {
      const simd::FloatMode mode;
      for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t row = bonds_.row_of(id(i));
        if (i < own_) rows_[i] = row;
        if (row != Bonds::kNone) note(row, i);
      }
    });
  }

  void note(std::uint32_t row, std::size_t i) {
    Knots::Knot& knot = knots_.knots[row];
    const bool pinned = bonds_.pin(row) != Bonds::kNone;
    for (std::size_t c = 0; c < 3; ++c) {
      knot.place[c] = columns_[c].of(i, own_);
      knot.velocity[c] = pinned ? 0 : columns_[3 + c].of(i, own_);
      knot.at[c] = knot.place[c] + knot.velocity[c] * terms_.dt;
    }
    const float mass = columns_[6].of(i, own_);
    knot.inverse = pinned ? 0 : mass >= kLightest ? 1 / mass : 1 / kLightest;
    knot.torn = static_cast<std::uint32_t>(columns_[7].of(i, own_));
    knot.seen = knots_.meeting;
  }

  std::uint64_t pull_all() {
    Store& store = *side(0).store;
    float* const v[3] = {store.writable_plane(particles::velocity, 0), store.writable_plane(particles::velocity, 1),
                         store.writable_plane(particles::velocity, 2)};
    float* const torn = terms_.break_at < kInf ? store.writable_plane(particles::torn, 0) : nullptr;
    const std::vector<std::uint8_t>* const chosen = side(0).chosen;
    std::vector<TieTotals> totals((own_ + meeting_.pool->items(kRange) - 1) / meeting_.pool->items(kRange));
    threads::over_ranges(*meeting_.pool, own_, kRange, [&](std::size_t first, std::size_t last) {
      const simd::FloatMode mode;
      for (std::size_t i = first; i < last; ++i) {
        if (rows_[i] == Bonds::kNone) continue;
        std::uint32_t tears = 0;
        const std::array<float, 3> now = pull(rows_[i], i, totals[first / meeting_.pool->items(kRange)], tears);
        if (tears != 0) torn[i] = static_cast<float>(knots_.knots[rows_[i]].torn | tears);
        if (chosen != nullptr && (*chosen)[i] == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) v[c][i] = now[c];
      }
    });
    TieTotals all;
    for (const TieTotals& some : totals) {
      all.ties += some.ties;
      all.longest2 = std::max(all.longest2, some.longest2);
    }
    knots_.longest = std::sqrt(all.longest2);
    return all.ties;
  }

  struct TieTotals {
    std::uint64_t ties = 0;
    float longest2 = 0;  // m2
  };

  // Returns the velocity that ties give a particle. Both ends of a tie compute its length from the same numbers, so
  // both find it torn.
  std::array<float, 3> pull(std::uint32_t row, std::size_t i, TieTotals& totals, std::uint32_t& tears) const {
    const Knots::Knot& own = knots_.knots[row];
    std::array<float, 3> sum{};
    std::array<float, 3> drift{};
    Spread spread;
    float count = 0;
    const std::size_t first = bonds_.first(row);
    for (std::size_t b = first; b < bonds_.first(row + 1); ++b) {
      const Bond& bond = bonds_.bond(b);
      const Knots::Knot& other = knots_.knots[bond.partner];
      const bool may_tear = b - first < kTearing;
      if (other.seen != knots_.meeting) continue;  // the partner is dead, or not yet born
      totals.longest2 = std::max(totals.longest2, distance2(own.place, other.place, periods_));
      if (may_tear && (own.torn >> (b - first) & 1u) != 0) continue;
      std::array<float, 3> d = from_partner(own, other);
      float r = length(d);
      if (may_tear && r > terms_.break_at * bond.length) {
        tears |= 1u << (b - first);
        continue;
      }
      float along = r;
      if (r < bond.length) hold_as_it_was(row, bond, d, r, along);
      const float weights = own.inverse + other.inverse + terms_.compliance[static_cast<std::size_t>(bond.kind)];
      if (r > 0 && weights > 0) {
        const float part = -own.inverse * (along - bond.length) / (weights * r);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += d[c] * part;
        const float both = other.inverse == 0 ? 1.0f : 2.0f;  // a moving partner doubles the correction
        spread.add(d, both * own.inverse / (weights * r * r));
      }
      for (std::size_t c = 0; c < 3; ++c) drift[c] += other.velocity[c];
      count += 1;
    }
    totals.ties += static_cast<std::uint64_t>(count);
    if (own.inverse == 0) return {};
    std::array<float, 3> at = {own.at[0], own.at[1], own.at[2]};
    if (count > 0) {
      // Damps only the velocity relative to the partners, so a fall is not slowed.
      const float lost = (1 - terms_.undamped) * terms_.dt;
      const float relaxed = std::min(kRelaxation / count, kStable / std::max(spread.most(), 1e-20f));
      for (std::size_t c = 0; c < 3; ++c) {
        at[c] += sum[c] * relaxed + (drift[c] / count - own.velocity[c]) * lost;
      }
    }
    if (terms_.tethers) hold(row, at);
    std::array<float, 3> now{};
    for (std::size_t c = 0; c < 3; ++c) now[c] = (at[c] - columns_[c].of(i, own_)) / terms_.dt;
    return now;
  }

  // Returns the predicted vector from a partner, or from its image that is nearest now. The other end gets the opposite
  // vector, with the same bits.
  std::array<float, 3> from_partner(const Knots::Knot& own, const Knots::Knot& other) const {
    std::array<float, 3> d = {own.at[0] - other.at[0], own.at[1] - other.at[1], own.at[2] - other.at[2]};
    for (int axis = 0; periods_.any() && axis < 3; ++axis) {
      const auto c = static_cast<std::size_t>(axis);
      const double shift = periods_.shift(axis, own.place[c] - other.place[c]);
      if (shift != 0)
        d[c] = static_cast<float>(static_cast<double>(own.at[c]) - static_cast<double>(other.at[c]) + shift);
    }
    return d;
  }

  // Two that fly past each other would be pushed on by a tie that is too short along its predicted direction, and gain
  // energy. If so, sets `d` and `r` to the vector from the partner before the step, and `along` to the predicted length
  // in its direction. Both ends of a tie decide alike.
  void hold_as_it_was(std::uint32_t row, const Bond& bond, std::array<float, 3>& d, float& r, float& along) const {
    const Knots::Knot &own = knots_.knots[row], &other = knots_.knots[bond.partner];
    std::array<float, 3> was;
    for (std::size_t c = 0; c < 3; ++c) was[c] = periods_.shortest(static_cast<int>(c), own.place[c] - other.place[c]);
    const float before = length(was), inner = dot(d, was);
    if (!(inner < kTurned * r * before)) return;
    const std::size_t ties = std::max(ties_of(row), ties_of(bond.partner));
    const float part = std::min(kStable, kRelaxation / static_cast<float>(ties));  // corrected
    const float push = part * (bond.length - r), approach = inner / r - r;
    const float spare = part * std::max(bond.length - before, 0.0f);  // what it may give back
    if (push - approach <= std::max(approach, 2 * spare)) return;
    along = inner / before;
    d = was;
    r = before;
  }

  std::size_t ties_of(std::uint32_t row) const { return bonds_.first(row + 1) - bonds_.first(row); }

  // Returns the position of a pinned particle, or of its image that is nearest to `own`.
  std::array<float, 3> pin_near(const Knots::Knot& own, std::uint32_t number) const {
    const float* const pin = &(*pins_)[3 * static_cast<std::size_t>(number)];
    std::array<float, 3> at = {pin[0], pin[1], pin[2]};
    for (int axis = 0; periods_.any() && axis < 3; ++axis) {
      const auto c = static_cast<std::size_t>(axis);
      at[c] = static_cast<float>(static_cast<double>(at[c]) - periods_.shift(axis, own.place[c] - at[c]));
    }
    return at;
  }

  // Limits the distance from pinned particles to the length of each tether. Skips tethers longer than half a period,
  // whose image is ambiguous.
  void hold(std::uint32_t row, std::array<float, 3>& at) const {
    for (std::size_t t = bonds_.first_tether(row); t < bonds_.first_tether(row + 1); ++t) {
      const Tether& tether = bonds_.tether(t);
      if (tether.length > longest_tether_) continue;
      const std::array<float, 3> pin = pin_near(knots_.knots[row], tether.pin);
      const std::array<float, 3> d = {at[0] - pin[0], at[1] - pin[1], at[2] - pin[2]};
      const float r = length(d);
      if (!(r > tether.length) || !(r < kInf)) continue;
      for (std::size_t c = 0; c < 3; ++c) at[c] = pin[c] + d[c] * (tether.length / r);
    }
  }

  static constexpr std::size_t kRange = std::size_t{1} << 12;

  const std::shared_ptr<const Bonds> owner_ = bonds(key_of(action()));
  const Bonds& bonds_ = *owner_;
  const Terms terms_ = terms_of(action(), meeting_.step.dt);
  const particles::Periods& periods_ = *meeting_.periods;
  const float longest_tether_ = periods_.half();  // m
  Knots& knots_ = meeting_.scratch->knots[{side(0).system, key_of(action())}];
  const std::vector<float>* pins_ = nullptr;  // x, y, z of all pinned particles
  std::vector<Column> columns_;
  std::size_t own_ = 0, count_ = 0;
  std::vector<std::uint32_t> rows_;
};

}  // namespace

void check(const actions::Action& action) {
  const std::shared_ptr<const Bonds> known = bonds(key_of(action));
  if (break_at_of(action) >= static_cast<double>(kInf) || known->most() <= kTearing) return;
  throw base::InvalidArgument("break_at", "be infinite if a particle has more than " + std::to_string(kTearing) +
                                              " ties, and one has " + std::to_string(known->most()));
}

void check_together(const actions::Action& one, const actions::Action& other) {
  const double break_at = std::min(break_at_of(one), break_at_of(other));
  if (key_of(one) == key_of(other) || break_at >= static_cast<double>(kInf)) return;
  const std::optional<std::uint64_t> both = shared_particle(key_of(one), key_of(other));
  if (!both) return;
  throw base::InvalidArgument("break_at",
                              "be infinite if two Ties of a list share a particle, and both tie " +
                                  std::to_string(*both) + " (a single Ties of all these pairs can tear)",
                              std::to_string(break_at));
}

std::unique_ptr<PairAction> families::tying(const Meeting& meeting) { return std::make_unique<Tying>(meeting); }

}  // namespace motes::interactions
