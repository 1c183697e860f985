#include "interactions/neighbour_list.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "interactions/extent.h"
#include "interactions/kernels.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

// Slots behind the last pair that vectors may read.
constexpr std::size_t kRoom = particles::kPadding;

particles::Touch touch_of(std::uint64_t id, std::uint32_t law, std::uint32_t part, const PairState& state) {
  particles::Touch touch{id, particles::law_part(law, part), state.step, {}, {}};
  std::copy_n(state.slid, 3, touch.slid);
  std::copy_n(state.rolled, 3, touch.rolled);
  return touch;
}

PairState state_of(const particles::Touch& touch) {
  PairState state{{}, {}, touch.step, 0};
  std::copy_n(touch.slid, 3, state.slid);
  std::copy_n(touch.rolled, 3, state.rolled);
  return state;
}

}  // namespace

void NeighbourList::set_kind(const Kind& kind) {
  if (kind == kind_) return;
  *this = {};
  kind_ = kind;
}

void NeighbourList::write_down(particles::Store& store, std::uint32_t law, std::uint32_t now) {
  const std::vector<std::uint32_t>& order = cells_.order();
  std::vector<particles::Touch> touches;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (order[k] >= own_) continue;
    touches.clear();
    for (const particles::Touch& touch : store.touches(order[k])) {
      const bool acted = particles::law_of(touch) <= law;  // later laws have yet to act
      const std::uint32_t last = acted ? now : now - 1;
      if (!particles::is_of_pair(touch, law) && touch.step == last) touches.push_back(touch);
    }
    recall(k, law, touches);
    store.set_touches(order[k], touches);
  }
  pending_ = false;
}

bool NeighbourList::lists(const Crowd& own, std::uint32_t now) const {
  if (begin_.empty() || now_ + 1 != now || own_ != own.own) return false;
  for (std::size_t i = 0; i < own_; ++i) {
    if (listed_[i] != own.own_ids[i]) return false;
  }
  return true;
}

bool NeighbourList::holds(const Crowd& own, const Radii& radii, std::uint32_t now, threads::Pool& pool) {
  ++wear_.age;
  if (!lists(own, now)) return false;
  std::atomic<bool> moved = false;
  std::vector<float> farthest(own_ / pool.items(kRange) + 1);
  threads::over_ranges(pool, own_, kRange, [&](std::size_t first, std::size_t last) {
    const simd::FloatMode mode;
    int far = 0;
    float most2 = 0;
    for (std::size_t i = first; i < last; ++i) {
      float way2 = 0;
      int numbers = 1;
      for (std::size_t c = 0; c < 3; ++c) {
        const float x = own.at[c].of(i, own_);
        const float way = x - at_[c][i];
        way2 += way * way;
        numbers &= static_cast<int>(!std::isnan(x));
      }
      // 0.49 instead of 0.5 leaves room for rounding.
      const float left = 0.49f * skin_ - std::max(0.0f, radii.of(i) - radius_[i]);
      most2 = way2 > most2 ? way2 : most2;
      far |= numbers & static_cast<int>(!(left > 0 && way2 < left * left));
    }
    if (far != 0) moved = true;
    farthest[first / pool.items(kRange)] = std::sqrt(most2);
  });
  wear_.step = *std::max_element(farthest.begin(), farthest.end()) / wear_.age;
  return !moved;
}

// Chooses the skin. Building a list costs about as much as checking 50 pairs per particle, and pairs grow with the cube
// of the reach. So the cost per step is lowest with a skin of sqrt(kWorth * step * reach), where step is the fastest
// particle's displacement per step. If the last list ended early for another reason, such as births or migrants, a
// thinner skin suffices.
float skin_of(const Wear& wear, float reach) {
  constexpr float kWorth = 7;
  const float first = wear.age > 1 ? 0.02f * reach : 0.1f * reach;
  const float best = wear.step < 0 ? first : std::min(std::sqrt(kWorth * wear.step * reach), 4 * wear.step * wear.age);
  return std::clamp(best, 0.01f * reach, 0.5f * reach);
}

void NeighbourList::note(const Crowd& own, float radius, float skin) {
  skin_ = skin;
  wear_.age = 0;
  own_ = own.own;
  begin_.assign(1, 0);
  listed_.clear();
  for (std::size_t i = 0; i < own_; ++i) listed_.push_back(own.own_ids[i]);
  for (std::size_t c = 0; c < 3; ++c) {
    at_[c].resize(own_);
    for (std::size_t i = 0; i < own_; ++i) at_[c][i] = own.at[c].of(i, own_);
  }
  radius_.assign(own_, radius);
}

void NeighbourList::sort(const Crowd& crowd, float reach, float skin, threads::Pool& pool) {
  skin_ = skin;
  wear_.age = 0;
  cells_.sort(crowd, (static_cast<double>(reach) + static_cast<double>(skin_)) * (1 + kMargin), pool);
}

void NeighbourList::build(const Crowd& crowd, const PlacedSpheres& spheres, const particles::Store& store,
                          std::uint32_t law, std::uint32_t now, threads::Pool& pool) {
  const std::vector<std::uint32_t>& order = cells_.order();
  const Remembered before{std::move(ids_), std::move(begin_), std::move(second_), std::move(state_)};
  own_ = crowd.own;
  listed_.resize(own_);
  for (std::vector<float>* column : {&at_[0], &at_[1], &at_[2], &radius_}) column->resize(own_);
  ids_.resize(crowd.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::uint32_t i = order[k];
    ids_[k] = crowd.id(i);
    if (i >= own_) continue;
    listed_[i] = ids_[k];
    for (std::size_t c = 0; c < 3; ++c) at_[c][i] = spheres.at[c][k];
    radius_[i] = spheres.radius[k];
  }
  find_pairs(crowd, spheres, pool);
  if (kind_.of_clumps && !kind_.ghosts_alone) drop_own_spheres();
  state_.assign((pairs() + kRoom) * kind_.parts, PairState{});
  const std::vector<Known> known = now_ + 1 == now ? before.touching(now_, kind_.parts) : std::vector<Known>{};
  threads::over_ranges(pool, order.size(), kRange, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      if (begin_[k] == begin_[k + 1]) continue;
      sort_pairs(k);
      const auto found = std::lower_bound(known.begin(), known.end(), Known{ids_[k], 0});
      if (found != known.end() && found->id == ids_[k]) {
        carry(before, found->place, now - 1, k);
      } else {
        for (const particles::Touch& touch : store.touches(order[k])) {
          if (!particles::is_of_pair(touch, law) || touch.step != now - 1) continue;
          put_state(k, touch.id, particles::part_of(touch) - kind_.first_part, state_of(touch));
        }
      }
    }
  });
}

// Counts the pairs of each particle, then lists them.
void NeighbourList::find_pairs(const Crowd& crowd, const PlacedSpheres& spheres, threads::Pool& pool) {
  const float* columns[party_columns] = {};
  for (int c = 0; c < 3; ++c) columns[at_x + c] = spheres.at[c];
  columns[radius] = spheres.radius;
  const std::vector<std::size_t> cuts = parts_of(cells_, pool);
  begin_.assign(ids_.size() + 1, 0);
  ListTask task{
      {cells_.view(own_), columns, &crowd}, skin_, kind_.ghosts_alone, begin_.data() + 1, begin_.data(), nullptr};
  const auto run = [&] {
    pool.run(cuts.size() - 1, [&](std::size_t part, std::size_t) {
      const simd::FloatMode mode;
      ListTask of_part = task;
      of_part.first_row = cuts[part];
      of_part.last_row = cuts[part + 1];
      kernels().list_pairs(of_part);
    });
  };
  run();
  std::uint64_t all = 0;
  for (std::uint32_t& begin : begin_) {
    all += begin;
    if (all > UINT32_MAX) throw std::length_error("more than 4294967295 pairs within reach on one rank");
    begin = static_cast<std::uint32_t>(all);
  }
  second_.resize(all + kRoom);
  task.second = second_.data();
  run();
}

// Drops pairs of spheres of one clump, which do not push each other.
void NeighbourList::drop_own_spheres() {
  std::uint32_t kept = 0, first = 0;
  for (std::size_t k = 0; k < ids_.size(); ++k) {
    const std::uint32_t end = begin_[k + 1];
    begin_[k] = kept;
    for (; first < end; ++first) {
      if (clump_of(ids_[second_[first]]) != clump_of(ids_[k])) second_[kept++] = second_[first];
    }
  }
  begin_.back() = kept;
  second_.resize(kept + kRoom);
}

// Sorts the pairs of a place by id, the order in which their effects are summed.
void NeighbourList::sort_pairs(std::size_t place) {
  std::sort(second_.begin() + begin_[place], second_.begin() + begin_[place + 1],
            [&](std::uint32_t a, std::uint32_t b) { return ids_[a] < ids_[b]; });
}

void NeighbourList::put_state(std::size_t place, std::uint64_t id, std::uint32_t part, const PairState& remembered) {
  const auto end = second_.begin() + begin_[place + 1];
  const auto found = std::lower_bound(second_.begin() + begin_[place], end, id,
                                      [&](std::uint32_t a, std::uint64_t id) { return ids_[a] < id; });
  if (part >= kind_.parts) return;
  for (auto second = found; second != end && ids_[*second] == id; ++second) {  // images of it, too
    state_[static_cast<std::size_t>(second - second_.begin()) * kind_.parts + part] = remembered;
  }
}

void NeighbourList::carry(const Remembered& before, std::uint32_t from, std::uint32_t step, std::size_t to) {
  for (std::uint32_t e = before.begin[from]; e < before.begin[from + 1]; ++e) {
    for (std::uint32_t part = 0; part < kind_.parts; ++part) {
      const PairState& state = before.state[std::size_t{e} * kind_.parts + part];
      if (state.step == step) put_state(to, before.ids[before.second[e]], part, state);
    }
  }
}

void NeighbourList::recall(std::size_t place, std::uint32_t law, std::vector<particles::Touch>& to) const {
  for (std::uint32_t e = begin_[place]; e < begin_[place + 1]; ++e) {
    for (std::uint32_t part = 0; part < kind_.parts; ++part) {
      const PairState& state = state_[std::size_t{e} * kind_.parts + part];
      if (state.step == now_) to.push_back(touch_of(ids_[second_[e]], law, kind_.first_part + part, state));
    }
  }
}

std::vector<NeighbourList::Known> NeighbourList::Remembered::touching(std::uint32_t step, std::uint32_t parts) const {
  std::vector<Known> known;
  for (std::uint32_t k = 0; k < ids.size(); ++k) {
    const auto at = [&](std::uint32_t pair) {
      return state.begin() + static_cast<std::ptrdiff_t>(std::size_t{pair} * parts);
    };
    const auto first = at(begin[k]), last = at(begin[k + 1]);
    if (std::any_of(first, last, [&](const PairState& one) { return one.step == step; })) known.push_back({ids[k], k});
  }
  std::sort(known.begin(), known.end());
  return known;
}

// Skips the ghosts in a list: their owners write their touches. In a list of clumps, each sphere has its own place.
void write_down_touches(const NeighbourLists& lists, std::size_t system, const std::map<std::uint32_t, int>& migrants,
                        particles::Store& store) {
  std::unordered_map<std::uint64_t, std::uint32_t> index_of;
  for (const auto& [i, owner] : migrants) index_of[store.ids()[i]] = i;
  for (const auto& [key, list] : lists) {
    if (key.first != system || !list.pending() || migrants.empty()) continue;
    for (std::size_t place = 0; place < list.ids().size(); ++place) {
      const bool sphere = list.of_clumps();
      const auto found = index_of.find(sphere ? clump_of(list.ids()[place]) : list.ids()[place]);
      if (found == index_of.end() || !list.owns(place)) continue;
      const std::uint32_t number = sphere ? number_of(list.ids()[place]) : 0;
      std::vector<particles::Touch> touches;
      for (const particles::Touch& touch : store.touches(found->second)) {
        const bool replaced =
            particles::is_of_pair(touch, key.second) && (!sphere || particles::part_of(touch) == number);
        if (!replaced) touches.push_back(touch);
      }
      const std::size_t kept = touches.size();
      list.recall(place, key.second, touches);
      for (std::size_t n = kept; sphere && n < touches.size(); ++n)
        touches[n].law = particles::law_part(key.second, number);
      store.set_touches(found->second, touches);
    }
  }
}

}  // namespace motes::interactions
