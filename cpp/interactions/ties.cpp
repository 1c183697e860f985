#include "interactions/ties.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <tuple>

#include "base/checks.h"
#include "base/registry.h"

namespace motes::interactions {

namespace {

constexpr float kLongest = 1e9f;  // m

void check_ends(const Ties& ties) {
  const std::size_t count = ties.ends.size() / 2;
  if (ties.ends.size() % 2 != 0)
    base::refuse("pairs", "two ids for each tie", std::to_string(ties.ends.size()) + " ids");
  if (ties.lengths.size() != count) {
    base::refuse("lengths", "one per tie, " + std::to_string(count), std::to_string(ties.lengths.size()));
  }
  if (ties.kinds.size() != count) {
    base::refuse("kinds", "one per tie, " + std::to_string(count), std::to_string(ties.kinds.size()));
  }
  std::vector<std::pair<std::uint64_t, std::uint64_t>> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string at = "[" + std::to_string(i) + "]";
    if (ties.ends[2 * i] == ties.ends[2 * i + 1]) {
      base::refuse("pairs" + at, "two different ids", std::to_string(ties.ends[2 * i]) + " twice");
    }
    if (!(ties.lengths[i] >= 0 && ties.lengths[i] <= kLongest)) {
      base::refuse("lengths" + at, "0..1e9 m", std::to_string(ties.lengths[i]));
    }
    if (ties.kinds[i] > 2)
      base::refuse("kinds" + at, "0 (stretch), 1 (shear) or 2 (bend)", std::to_string(ties.kinds[i]));
    pairs.emplace_back(std::minmax(ties.ends[2 * i], ties.ends[2 * i + 1]));
  }
  std::sort(pairs.begin(), pairs.end());
  const auto twice = std::adjacent_find(pairs.begin(), pairs.end());
  if (twice != pairs.end()) {
    base::refuse("pairs", "different from each other",
                 std::to_string(twice->first) + " and " + std::to_string(twice->second) + " twice");
  }
}

void check_tethers(const Ties& ties) {
  if (ties.pins.size() != ties.tethered.size() || ties.tethers.size() != ties.tethered.size()) {
    base::refuse("tethers", "one per tethered particle", std::to_string(ties.tethers.size()));
  }
  for (std::size_t i = 0; i < ties.pins.size(); ++i) {
    if (ties.pins[i] >= ties.pinned.size())
      base::refuse("pins", "indices of pinned particles", std::to_string(ties.pins[i]));
    if (!(ties.tethers[i] >= 0 && ties.tethers[i] <= kLongest)) {
      base::refuse("tethers", "0..1e9 m", std::to_string(ties.tethers[i]));
    }
  }
}

base::Registry<Ties>& registry() {
  static base::Registry<Ties> all("set of ties");
  return all;
}

// A cache of facts about ties that every frame needs.
struct Known {
  std::mutex lock;
  std::map<TiesKey, std::shared_ptr<const Bonds>> bonds;
  std::map<std::pair<TiesKey, TiesKey>, std::optional<std::uint64_t>> shared;  // by two keys, the lower one first
};

Known& known() {
  static Known all;
  return all;
}

std::optional<std::uint64_t> lowest_tied_by_both(const Bonds& a, const Bonds& b) {
  const auto has_bonds = [](const Bonds& bonds, std::size_t row) { return bonds.first(row) < bonds.first(row + 1); };
  for (std::size_t i = 0, j = 0; i < a.rows() && j < b.rows();) {
    if (a.id(i) == b.id(j) && has_bonds(a, i) && has_bonds(b, j)) return a.id(i);
    const bool next_of_a = a.id(i) <= b.id(j), next_of_b = b.id(j) <= a.id(i);
    i += next_of_a ? 1 : 0;
    j += next_of_b ? 1 : 0;
  }
  return std::nullopt;
}

}  // namespace

void check(const Ties& ties) {
  check_ends(ties);
  check_tethers(ties);
}

Bonds::Bonds(const Ties& ties) : pins_(ties.pinned.size()) {
  ids_ = ties.ends;
  ids_.insert(ids_.end(), ties.pinned.begin(), ties.pinned.end());
  ids_.insert(ids_.end(), ties.tethered.begin(), ties.tethered.end());
  std::sort(ids_.begin(), ids_.end());
  ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
  std::vector<std::pair<std::uint32_t, Bond>> bonds;
  for (std::size_t i = 0; i < ties.lengths.size(); ++i) {
    const std::uint32_t a = row_of(ties.ends[2 * i]);
    const std::uint32_t b = row_of(ties.ends[2 * i + 1]);
    const auto kind = static_cast<TieKind>(ties.kinds[i]);
    bonds.push_back({a, {b, ties.lengths[i], kind}});
    bonds.push_back({b, {a, ties.lengths[i], kind}});
  }
  std::sort(bonds.begin(), bonds.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first, a.second.partner) < std::tie(b.first, b.second.partner);
  });
  first_.assign(ids_.size() + 1, 0);
  for (const auto& [row, bond] : bonds) ++first_[row + 1], bonds_.push_back(bond);
  first_tether_.assign(ids_.size() + 1, 0);
  std::vector<std::pair<std::uint32_t, Tether>> tethers;
  for (std::size_t i = 0; i < ties.tethered.size(); ++i) {
    tethers.push_back({row_of(ties.tethered[i]), {ties.pins[i], ties.tethers[i]}});
  }
  std::sort(tethers.begin(), tethers.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first, a.second.pin) < std::tie(b.first, b.second.pin);
  });
  for (const auto& [row, tether] : tethers) ++first_tether_[row + 1], tethers_.push_back(tether);
  for (std::size_t row = 0; row < ids_.size(); ++row) {
    most_ = std::max<std::size_t>(most_, first_[row + 1]);
    first_[row + 1] += first_[row];
    first_tether_[row + 1] += first_tether_[row];
  }
  pin_.assign(ids_.size(), kNone);
  for (std::size_t p = 0; p < ties.pinned.size(); ++p) pin_[row_of(ties.pinned[p])] = static_cast<std::uint32_t>(p);
}

std::uint32_t Bonds::row_of(std::uint64_t id) const {
  if (ids_.empty() || id < ids_.front() || id > ids_.back()) return kNone;
  const std::uint64_t ahead = id - ids_.front();  // ids of one cloth are consecutive
  if (ids_.back() - ids_.front() + 1 == ids_.size()) return static_cast<std::uint32_t>(ahead);
  const auto found = std::lower_bound(ids_.begin(), ids_.end(), id);
  return *found == id ? static_cast<std::uint32_t>(found - ids_.begin()) : kNone;
}

TiesKey keep(Ties ties) { return registry().keep(std::move(ties)); }

std::optional<std::uint64_t> shared_particle(TiesKey one, TiesKey other) {
  const std::pair<TiesKey, TiesKey> both = std::minmax(one, other);
  {
    const std::scoped_lock held(known().lock);
    const auto found = known().shared.find(both);
    if (found != known().shared.end()) return found->second;
  }
  const std::optional<std::uint64_t> lowest = lowest_tied_by_both(*bonds(one), *bonds(other));
  const std::scoped_lock held(known().lock);
  return known().shared[both] = lowest;
}

std::shared_ptr<const Ties> ties(TiesKey key) { return registry().get(key); }

std::shared_ptr<const Bonds> bonds(TiesKey key) {
  const std::shared_ptr<const Ties> content = ties(key);
  const std::scoped_lock held(known().lock);
  std::shared_ptr<const Bonds>& made = known().bonds[key];
  if (made == nullptr) made = std::make_shared<const Bonds>(*content);
  return made;
}

void write_ties(const std::set<TiesKey>& keys, base::Bytes& out) { registry().write(keys, out); }

void read_ties(base::Reader& in) { registry().read(in); }

}  // namespace motes::interactions
