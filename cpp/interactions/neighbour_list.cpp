#include "interactions/neighbour_list.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include "interactions/extent.h"
#include "interactions/kernels.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

// Slots behind the last pair that vectors may read.
constexpr std::size_t kRoom = particles::kPadding;
constexpr std::uint64_t kMostPairs = INT32_MAX - 1;  // each has two ends, counted by 32 bits

// Adds what one end of a pair remembers. Number by number: vectors over halves just stored would wait for them.
void add_touch(std::uint64_t id, std::uint32_t law, const PairState& state, bool mirrored,
               std::vector<particles::Touch>& to) {
  particles::Touch& touch = to.emplace_back();
  touch.id = id;
  touch.law = law;
  touch.step = state.step;
  for (int c = 0; c < 3; ++c) {  // + 0: ends that compute a pair apart may differ by the sign of 0
    touch.slid[c] = (mirrored ? 0.0f - state.slid[c] : state.slid[c]) + 0.0f;
    touch.rolled[c] = state.rolled[c];
  }
}

// Returns the state as the other end of the pair remembers it.
PairState back(const PairState& state) {
  PairState mirrored = state;
  for (float& x : mirrored.slid) x = 0.0f - x;
  return mirrored;
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
  *this = NeighbourList(near_.kernels());
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

bool NeighbourList::holds(const Crowd& own, const Radii& radii, std::uint32_t now, threads::Pool& pool,
                          const particles::Periods& periods) {
  ++wear_.age;
  if (!lists(own, now)) return false;
  const Ends ends(periods);
  WearTask task;
  for (std::size_t c = 0; c < 3; ++c) {
    task.at[c] = own.at[c];
    task.listed[c] = at_[c].data();
  }
  task.size = radii.size;
  task.mass = radii.mass;
  task.given = radii.given;
  task.skips_massless = radii.skips_massless;
  task.listed_radius = radius_.data();
  task.ends = &ends;
  task.skin = skin_;
  const std::size_t range = pool.items(kRange);
  std::vector<Worn> worn(own_ / range + 1);
  threads::over_ranges(pool, own_, kRange, [&](std::size_t first, std::size_t last) {
    const simd::FloatMode mode;
    WearTask of_range = task;
    of_range.from = first;
    of_range.to = last;
    worn[first / range] = near_.kernels().measure_wear(of_range);
  });
  float most2 = 0;
  bool out = false;
  for (const Worn& one : worn) {
    most2 = std::max(most2, one.way2);
    out = out || one.out;
  }
  wear_.step = std::sqrt(most2) / wear_.age;
  return !out;
}

// Tries skins that let a list hold for one sub-step, two, and so on; that of the lowest cost per sub-step is the next.
// A new list costs what the sweep over candidates does, which grow with the cube of the reach, and a sort. In each
// sub-step, pairs are looked at: all of them, or only near ones. If the last list ended early for another reason, such
// as births or migrants, a thinner skin suffices.
float skin_of(const Wear& wear, float reach, bool near) {
  constexpr float kSort = 1.6f, kLook = 0.1f, kLookAtNear = 0.0065f;  // in units of a sweep with no skin
  constexpr float kThinnest = 0.01f, kThickest = 0.5f;                // relative to the reach
  if (wear.step < 0) return (wear.age > 1 ? 0.02f : 0.1f) * reach;
  const float step = wear.step / reach;
  const float most = std::min(kThickest, 4 * step * wear.age);
  float best = kThinnest, least = std::numeric_limits<float>::infinity();
  for (float steps = 0; steps < 65536; steps = std::floor(steps * 1.125f) + 1) {
    const float skin = std::max(kThinnest, steps * step * 2.1f);
    if (skin > most && steps > 0) break;
    const float volume = (1 + skin) * (1 + skin) * (1 + skin);
    const float cost = (volume + kSort) / (steps + 1) + volume * (near ? kLookAtNear : kLook);
    if (cost < least) {
      least = cost;
      best = skin;
    }
  }
  return best * reach;
}

void NeighbourList::note(const Crowd& own, float radius, float skin) {
  skin_ = skin;
  wear_.age = 0;
  own_ = own.own;
  begin_.assign(1, 0);
  listed_.clear();
  for (std::size_t i = 0; i < own_; ++i) listed_.push_back(own.own_ids[i]);
  for (std::size_t c = 0; c < 3; ++c) {
    at_[c].resize(padded(own_));
    for (std::size_t i = 0; i < own_; ++i) at_[c][i] = own.at[c].of(i, own_);
  }
  radius_.assign(padded(own_), radius);
}

void NeighbourList::sort(const Crowd& crowd, float reach, float skin, threads::Pool& pool) {
  skin_ = skin;
  wear_.age = 0;
  cells_.sort(crowd, (static_cast<double>(reach) + static_cast<double>(skin_)) * (1 + kMargin), pool);
}

void NeighbourList::build(const Crowd& crowd, const PlacedSpheres& spheres, const particles::Store& store,
                          std::uint32_t law, std::uint32_t now, threads::Pool& pool,
                          const std::vector<std::uint32_t>& originals) {
  const std::vector<std::uint32_t>& order = cells_.order();
  const Remembered before{std::move(ids_), std::move(begin_), std::move(second_), std::move(state_), near_.take()};
  own_ = crowd.own;
  listed_.resize(own_);
  for (std::vector<float>* column : {&at_[0], &at_[1], &at_[2], &radius_}) column->resize(padded(own_));
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
  if ((kind_.of_clumps && !kind_.ghosts_alone) || !originals.empty()) drop_pairs(crowd, originals);
  if (kind_.near) {
    first_.resize(second_.size());
    for (std::uint32_t k = 0; k < ids_.size(); ++k)
      std::fill(first_.begin() + begin_[k], first_.begin() + begin_[k + 1], k);
  }
  state_.assign((pairs() + kRoom) * kind_.states(), PairState{});
  if (kind_.apart) find_places();
  const std::vector<Known> known = now_ + 1 == now ? before.touching(now_, kind_) : std::vector<Known>{};
  threads::over_ranges(pool, order.size(), kRange, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      if (order[k] >= own_ || (begin_[k] == begin_[k + 1] && !kind_.apart)) continue;
      if (!kind_.near) sort_pairs(k);
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

TouchTask NeighbourList::touches(std::uint32_t now) {
  now_ = now;
  pending_ = true;
  TouchTask task;
  task.now = now;
  task.apart = kind_.apart;
  task.order = cells_.order().data();
  task.ids = ids_.data();
  task.places = static_cast<std::uint32_t>(ids_.size());
  task.own = static_cast<std::uint32_t>(own_);
  task.listed_first = first_.data();
  task.listed_second = second_.data();
  task.states = state_.data();
  task.begin = begin_.data();
  return task;
}

// Counts the pairs of each particle, then lists them.
void NeighbourList::find_pairs(const Crowd& crowd, const PlacedSpheres& spheres, threads::Pool& pool) {
  const float* columns[party_columns] = {};
  for (int c = 0; c < 3; ++c) columns[at_x + c] = spheres.at[c];
  columns[radius] = spheres.radius;
  const std::vector<std::size_t> cuts = parts_of(cells_, pool);
  begin_.assign(ids_.size() + 1, 0);
  ListTask task{{cells_.view(own_), columns, &crowd},
                skin_,
                kind_.ghosts_alone,
                kind_.near,
                begin_.data() + 1,
                begin_.data(),
                nullptr};
  const auto run = [&] {
    pool.run(cuts.size() - 1, [&](std::size_t part, std::size_t) {
      const simd::FloatMode mode;
      ListTask of_part = task;
      of_part.first_row = cuts[part];
      of_part.last_row = cuts[part + 1];
      near_.kernels().list_pairs(of_part);
    });
  };
  run();
  std::uint64_t all = 0;
  for (std::uint32_t& begin : begin_) {
    all += begin;
    if (all > kMostPairs)
      throw std::length_error("more than " + std::to_string(kMostPairs) + " pairs within reach on one rank");
    begin = static_cast<std::uint32_t>(all);
  }
  second_.resize(all + kRoom);
  task.second = second_.data();
  run();
}

// Drops pairs of spheres of one clump, which do not push each other. Replaces images by their originals; a pair of own
// particles whose two ends both saw an image was listed twice.
void NeighbourList::drop_pairs(const Crowd& crowd, const std::vector<std::uint32_t>& originals) {
  const std::vector<std::uint32_t>& order = cells_.order();
  const std::size_t originals_from = crowd.size() - originals.size();
  const auto place_of = originals.empty() ? std::vector<std::uint32_t>() : cells_.places();
  std::uint32_t kept = 0, first = 0;
  for (std::uint32_t k = 0; k < ids_.size(); ++k) {
    const std::uint32_t end = begin_[k + 1];
    begin_[k] = kept;
    for (; first < end; ++first) {
      std::uint32_t second = second_[first];
      if (kind_.of_clumps && !kind_.ghosts_alone && clump_of(ids_[second]) == clump_of(ids_[k])) continue;
      if (order[second] >= originals_from && !originals.empty()) {
        second = place_of[originals[order[second] - originals_from]];
        if (kind_.near && order[second] < own_ && second < k) continue;
      }
      second_[kept++] = second;
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

void NeighbourList::find_places() {
  const std::vector<std::uint32_t>& order = cells_.order();
  own_places_.resize(own_);
  for (std::uint32_t k = 0; k < order.size(); ++k) {
    if (order[k] < own_) own_places_[order[k]] = {ids_[k], k};
  }
  if (!std::is_sorted(own_places_.begin(), own_places_.end())) std::sort(own_places_.begin(), own_places_.end());
}

void NeighbourList::put_state(std::size_t place, std::uint64_t id, std::uint32_t part, const PairState& remembered) {
  if (part >= kind_.parts) return;
  const auto end = second_.begin() + begin_[place + 1];
  auto second = second_.begin() + begin_[place];
  if (!kind_.near) {
    second = std::lower_bound(second, end, id, [&](std::uint32_t a, std::uint64_t id) { return ids_[a] < id; });
  }
  for (; second != end; ++second) {  // images of it, too
    if (ids_[*second] != id) continue;
    state_[static_cast<std::size_t>(second - second_.begin()) * kind_.states() + part] = remembered;
  }
  if (kind_.apart) put_far_state(place, id, remembered);
}

// Sets what a place remembers of a pair that is listed at the other end.
void NeighbourList::put_far_state(std::size_t place, std::uint64_t id, const PairState& remembered) {
  const auto other = std::lower_bound(own_places_.begin(), own_places_.end(), Known{id, 0});
  if (other == own_places_.end() || other->id != id) return;
  for (std::uint32_t e = begin_[other->place]; e < begin_[other->place + 1]; ++e) {
    if (second_[e] == place) state_[2 * std::size_t{e} + 1] = remembered;
  }
}

void NeighbourList::carry(const Remembered& before, std::uint32_t from, std::uint32_t step, std::size_t to) {
  each_pair(kind_, before.near, before.begin, before.second, from,
            [&](std::size_t index, std::uint32_t other, bool mirrored) {
              for (std::uint32_t part = 0; part < kind_.parts; ++part) {
                const PairState& state = before.state[index + part];
                if (state.step == step) put_state(to, before.ids[other], part, mirrored ? back(state) : state);
              }
            });
}

void NeighbourList::recall(std::size_t place, std::uint32_t law, std::vector<particles::Touch>& to) const {
  each_pair(kind_, near_.links(), begin_, second_, place, [&](std::size_t index, std::uint32_t other, bool mirrored) {
    for (std::uint32_t part = 0; part < kind_.parts; ++part) {
      const PairState& state = state_[index + part];
      if (state.step != now_) continue;
      add_touch(ids_[other], particles::law_part(law, kind_.first_part + part), state, mirrored, to);
    }
  });
}

std::vector<NeighbourList::Known> NeighbourList::Remembered::touching(std::uint32_t step, const Kind& kind) const {
  std::vector<Known> known;
  for (std::uint32_t k = 0; k < ids.size(); ++k) {
    bool touches = false;
    each_pair(kind, near, begin, second, k, [&](std::size_t index, std::uint32_t, bool) {
      for (std::uint32_t part = 0; part < kind.parts; ++part) touches |= state[index + part].step == step;
    });
    if (touches) known.push_back({ids[k], k});
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
