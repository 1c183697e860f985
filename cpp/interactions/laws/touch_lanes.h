// Touches of grains with each other. Each pair is computed once, for both ends: what one end gets is what the other
// gets with the opposite sign, to the last bit. Each grain then sums its pushes in the order of the others' ids.
#pragma once

#include "interactions/displacements.h"
#include "interactions/grains.h"
#include "interactions/laws/law_contact.h"
#include "interactions/quads3.h"

namespace motes::MOTES_ISA {

using interactions::Course;
using interactions::Grain;
using interactions::GrainPush;
using interactions::TouchTask;

/// A number per lane, to compute addresses from.
struct LaneNumbers {
  alignas(64) std::uint32_t of[kLanes];

  MOTES_INLINE explicit LaneNumbers(Uints numbers) { store_uints(of, numbers); }
  MOTES_INLINE LaneNumbers(const std::uint32_t* table, const LaneNumbers& at) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) of[lane] = table[at.of[lane]];
  }
};

/// Loads positions, m, and radii, or motion per sub-step of courses or grains.
template <class Record>
MOTES_INLINE FourWords load_at(const Record* records, const LaneNumbers& places) {
  return load_fours([&](std::size_t lane) { return records[places.of[lane]].at; });
}

/// Returns whether a grain is far from its course, or has grown. A grain at NaN touches nothing.
inline bool strays(const interactions::PlaceTask& task, const Grain& grain, const Course& course) {
  float way2 = 0;
  for (int c = 0; c < 3; ++c) {
    if (grain.at[c] != grain.at[c]) return false;  // NOLINT(misc-redundant-expression): NaN
    const float way = shortest(grain.at[c] - course.at[c], *task.ends, c) - course.step[c] * task.age;
    way2 += way * way;
  }
  return grain.radius > course.radius || !(way2 < task.far * task.far);
}

/// Arranges grains; returns whether all are near their courses.
inline bool place_grains(const interactions::PlaceTask& task) {
  const interactions::GrainColumns& columns = *task.columns;
  const interactions::Column* const all_columns[11] = {&columns.at[0],       &columns.at[1],       &columns.at[2],
                                                       &columns.size,        &columns.velocity[0], &columns.velocity[1],
                                                       &columns.velocity[2], &columns.mass,        &columns.spin[0],
                                                       &columns.spin[1],     &columns.spin[2]};
  const float* own[11];
  std::uint32_t mask[11];
  for (int c = 0; c < 11; ++c) {
    own[c] = all_columns[c]->own != nullptr ? all_columns[c]->own : &all_columns[c]->value;
    mask[c] = all_columns[c]->own != nullptr ? UINT32_MAX : 0;
  }
  const Four age = Four{} + task.age, far2 = Four{} + task.far * task.far;
  bool all_near = true;
  for (std::uint32_t k = task.from; k < task.to; ++k) {
    const std::uint32_t i = task.order[k];
    if (i >= task.count) continue;
    float v[11];
    if (i < task.own) {
      for (int c = 0; c < 11; ++c) v[c] = own[c][i & mask[c]];
    } else {
      for (int c = 0; c < 11; ++c) v[c] = all_columns[c]->ghosts[i - task.own];
    }
    const bool given = columns.given > 0 && (i < task.own || !columns.given_own);
    const bool heavy = v[7] >= interactions::kLeastMass;
    const float radius = !heavy ? 0.0f : given ? columns.given : v[3] > 0 ? 0.5f * v[3] : 0.0f;
    Grain& grain = task.grains[k];
    grain = {{v[0], v[1], v[2]},  radius, {v[4], v[5], v[6]}, 1 / (heavy ? v[7] : interactions::kLeastMass),
             {v[8], v[9], v[10]}, 0};
    if (task.courses == nullptr) continue;
    const Course& course = task.courses[k];
    Four way = load_four(grain.at) - load_four(course.at) - load_four(course.step) * age;
    way *= way;
    const bool near = way[0] + way[1] + way[2] < far2[0] && !(way[3] > 0);
    if (!near && strays(task, grain, course)) all_near = false;
  }
  return all_near;
}

/// Starts the courses of the places from `from` on.
inline void set_courses(const TouchTask& task) {
  for (std::uint32_t k = task.from; k < task.to; ++k) {
    const Grain& grain = task.grains[k];
    const float x = grain.velocity[0] * task.dt, y = grain.velocity[1] * task.dt, z = grain.velocity[2] * task.dt;
    // Squares of longer ways would leave float32's range. Such a grain is far from its course at once.
    const bool moves = x * x + y * y + z * z < 1e30f;
    task.courses[k] = {{grain.at[0], grain.at[1], grain.at[2]},
                       grain.radius,
                       {moves ? x : 0.0f, moves ? y : 0.0f, moves ? z : 0.0f},
                       0};
  }
}

/// Writes the near ones of some listed pairs from near pair `from` on; returns their number.
inline std::uint32_t find_near(const TouchTask& task) {
  std::uint32_t count = task.from;
  for (std::uint32_t n = task.from; n < task.to; n += kLanes) {
    const Mask here = first_lanes(task.to - n);
    const Uints i = load_uints(task.listed_first + n) & (Uints)here,
                j = load_uints(task.listed_second + n) & (Uints)here;
    const LaneNumbers first(i), second(j);
    const auto step = [&](const LaneNumbers& of) __attribute__((always_inline)) {
      return three(load_fours([&](std::size_t lane) { return task.courses[of.of[lane]].step; }));
    };
    const FourWords a = load_at(task.courses, first), b = load_at(task.courses, second);
    const Floats3 r = shortest(three(b) - three(a), *task.ends), w = step(second) - step(first);
    // The time at which they are closest, and their displacement then.
    const Floats soonest = -dot(r, w) / max(dot(w, w), all(1e-37f));
    const Floats3 q = r + w * min(max(soonest, Floats{}), all(task.steps));
    const Floats reach = fourth(a) + fourth(b) + task.skin;
    const Mask near = (dot(q, q) < reach * reach) & (min(fourth(a), fourth(b)) > 0.0f) & here;
    const Selected selected(near);
    store_selected(task.first + count, selected, i);
    store_selected(task.second + count, selected, j);
    store_selected(task.pair + count, selected, lane_numbers() + n);
    count += static_cast<std::uint32_t>(selected.number());
  }
  return count - task.from;
}

/// Lists, for each place, the pushes of its near pairs in the order of the others' ids.
inline void order_pushes(const TouchTask& task) {
  const std::uint32_t near = task.to;
  for (std::uint32_t k = 0; k < task.places + 2; ++k) task.begin[k] = 0;
  const auto each = [&](const auto& visit) __attribute__((always_inline)) {
    for (std::uint32_t n = 0; n < near; ++n) {
      visit(task.first[n], 2 * n + 1);
      if (task.order[task.second[n]] < task.own) visit(task.second[n], 2 * n + 2);
    }
  };
  each([&](std::uint32_t place, std::uint32_t) { ++task.begin[place + 2]; });
  for (std::uint32_t k = 0; k < task.places; ++k) task.begin[k + 2] += task.begin[k + 1];
  each([&](std::uint32_t place, std::uint32_t push) { task.pushes[task.begin[place + 1]++] = push; });
  const auto other = [&](std::uint32_t push) {
    const std::uint32_t n = (push - 1) / 2;
    return task.ids[(push & 1) != 0 ? task.second[n] : task.first[n]];
  };
  for (std::uint32_t k = 0; k < task.places; ++k) {
    for (std::uint32_t a = task.begin[k] + 1; a < task.begin[k + 1]; ++a) {
      const std::uint32_t moved = task.pushes[a];
      const std::uint64_t id = other(moved);
      std::uint32_t b = a;
      for (; b > task.begin[k] && other(task.pushes[b - 1]) > id; --b) task.pushes[b] = task.pushes[b - 1];
      task.pushes[b] = moved;
    }
    for (std::uint32_t n = task.begin[k]; n < task.begin[k + 1]; ++n) task.pushed[n] = k;
  }
}

MOTES_INLINE void store_push(GrainPush* to, std::size_t lane, const Quads& velocity, const Quads& spin) {
  __builtin_memcpy(to->velocity, velocity.word[lane], 16);
  __builtin_memcpy(to->spin, spin.word[lane], 16);
}

/// Computes up to one vector of touches. `numbers`: 2 * near pair + the end that is the target.
template <bool kApart>
MOTES_INLINE void push_apart(const Contact& law, const TouchTask& task, const std::uint32_t* numbers,
                             std::uint32_t count) {
  const Mask here = first_lanes(count);
  const Uints end = load_uints(numbers) & (Uints)here;
  const LaneNumbers number(end), n(end >> 1);
  LaneNumbers first(task.first, n), second(task.second, n), state(task.pair, n);
  if (kApart) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t a = first.of[lane], b = second.of[lane], back = number.of[lane] & 1;
      first.of[lane] = back != 0 ? b : a;
      second.of[lane] = back != 0 ? a : b;
      state.of[lane] = 2 * state.of[lane] + back;
    }
  }
  const auto grain = [&](const LaneNumbers& of, int quad) __attribute__((always_inline)) {
    return load_fours([&](std::size_t lane) { return task.grains[of.of[lane]].at + 4 * quad; });
  };
  const FourWords i_at = grain(first, 0), j_at = grain(second, 0), i_velocity = grain(first, 1),
                  j_velocity = grain(second, 1);
  Touching t{};
  const Floats3 r = shortest(three(j_at) - three(i_at), *task.ends);
  const Floats d = sqrt(dot(r, r));
  t.normal = r * (1.0f / d);
  t.own = {fourth(i_at), fourth(i_velocity)};
  t.other = {fourth(j_at), fourth(j_velocity)};
  t.overlap = t.own.radius + t.other.radius - d;
  t.apart = three(j_velocity) - three(i_velocity);
  t.spin = three(grain(first, 2));
  t.other_spin = three(grain(second, 2));
  const Mask together = ~(Mask)(d > 0.0f) & here;
  if (any(together)) {
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      if (together[lane] == 0) continue;
      set_lane(t.normal, lane, parting(task.ids[first.of[lane]], task.ids[second.of[lane]], task.side));
    }
  }
  const auto stored = [&](int quad) __attribute__((always_inline)) {
    return load_fours([&](std::size_t lane) { return task.states[state.of[lane]].slid + 4 * quad; });
  };
  static_assert(sizeof(interactions::PairState) == 8 * sizeof(float));
  const FourWords low = stored(0), high = stored(1);
  const Mask known = (Mask)(high.word[2] + 1u == all_uints(task.now));
  Floats3 slid = only(known, three(low));
  Floats3 rolled = only(known, Floats3{fourth(low), (Floats)high.word[0], (Floats)high.word[1]});
  const Push push = law.push(t, slid, rolled);
  const Floats one = all(1.0f);
  const Quads velocity = quads_of(law.speed(push), one), spin = quads_of(law.turn(push), Floats{});
  const Quads new_low = quads_of(slid, rolled.x);
  const Quads new_high = quads_of((Uints)rolled.y, (Uints)rolled.z, all_uints(task.now), Uints{});
  for (std::uint32_t lane = 0; lane < count; ++lane) {
    store_push(task.push + number.of[lane] + 1, lane, velocity, spin);
    float* const to = task.states[state.of[lane]].slid;
    __builtin_memcpy(to, new_low.word[lane], 16);
    __builtin_memcpy(to + 4, new_high.word[lane], 16);
  }
  if (kApart) return;
  const Push back = push.back();
  const Quads other_velocity = quads_of(law.speed(back), one), other_spin = quads_of(law.turn(back), Floats{});
  for (std::uint32_t lane = 0; lane < count; ++lane)
    store_push(task.push + number.of[lane] + 2, lane, other_velocity, other_spin);
}

/// Touches to compute.
template <bool kApart>
class TouchBatch {
 public:
  MOTES_INLINE TouchBatch(const Contact& law, const TouchTask& task) : law_(law), task_(task) {}

  /// Adds the chosen near pairs from `n` on. Ends that may not change are only counted.
  MOTES_INLINE void add(std::uint32_t n, Mask chosen) {
    const auto found = static_cast<std::uint32_t>(squeeze(number_ + count_, (lane_numbers() + n) * 2, chosen));
    std::uint32_t found_here[kLanes];
    __builtin_memcpy(found_here, number_ + count_, sizeof found_here);
    for (std::uint32_t k = 0; k < found; ++k) task_.touched[found_here[k] / 2] = task_.now;
    if (!kApart) {
      count_ += found;
    } else {
      for (std::uint32_t k = 0; k < found; ++k) {
        add_end(found_here[k], task_.first[found_here[k] / 2]);
        add_end(found_here[k] + 1, task_.second[found_here[k] / 2]);
      }
    }
    if (count_ >= kMost) compute();
  }

  MOTES_INLINE void compute() {
    for (std::uint32_t n = 0; n < count_; n += kLanes)
      push_apart<kApart>(law_, task_, number_ + n,
                         count_ - n < kLanes ? count_ - n : static_cast<std::uint32_t>(kLanes));
    count_ = 0;
  }

 private:
  static constexpr std::uint32_t kMost = 256;

  MOTES_INLINE void add_end(std::uint32_t number, std::uint32_t place) {
    const std::uint32_t i = task_.order[place];
    if (i >= task_.own) return;
    if (task_.chosen[i] != 0) {
      number_[count_++] = number;
    } else {
      task_.push[number + 1] = {{0, 0, 0}, 1, {0, 0, 0}, 0};
    }
  }

  const Contact& law_;
  const TouchTask& task_;
  std::uint32_t count_ = 0;
  alignas(64) std::uint32_t number_[kMost + 4 * kLanes];
};

template <bool kApart>
MOTES_INLINE void touch_all(const TouchTask& task) {
  const Contact law = contact_of(task.numbers, task.dt);
  TouchBatch<kApart> batch(law, task);
  for (std::uint32_t n = task.from; n < task.to; n += kLanes) {
    const Mask here = first_lanes(task.to - n);
    const LaneNumbers first(load_uints(task.first + n) & (Uints)here);
    const LaneNumbers second(load_uints(task.second + n) & (Uints)here);
    const FourWords a = load_at(task.grains, first), b = load_at(task.grains, second);
    const Floats3 r = shortest(three(b) - three(a), *task.ends);
    const Floats reach = fourth(a) + fourth(b);
    const Mask near = (dot(r, r) < reach * reach) & (min(fourth(a), fourth(b)) > 0.0f) & here;
    const Mask parted = (Mask)(load_uints(task.touched + n) + 1u == all_uints(task.now)) & ~near & here;
    for (unsigned left = bits_of(parted); left != 0; left &= left - 1) {
      const std::uint32_t number = n + static_cast<std::uint32_t>(__builtin_ctz(left));
      task.push[2 * number + 1] = task.push[2 * number + 2] = {};
    }
    batch.add(n, near);
  }
  batch.compute();
}

/// Computes the touches of near pairs. Those that part now push no longer.
inline void touch(const TouchTask& task) { task.apart ? touch_all<true>(task) : touch_all<false>(task); }

/// Sums the pushes of places. Sums begin with +0; the grain's own velocity and spin are added last.
inline void sum_pushes(const TouchTask& task) {
  __builtin_memset(task.out + task.from, 0, (task.to - task.from) * sizeof(GrainPush));
  for (std::uint32_t n = task.begin[task.from]; n < task.begin[task.to]; ++n) {
    const GrainPush& push = task.push[task.pushes[n]];
    GrainPush& sum = task.out[task.pushed[n]];
    const Four velocity = load_four(sum.velocity) + load_four(push.velocity);
    const Four spin = load_four(sum.spin) + load_four(push.spin);
    __builtin_memcpy(sum.velocity, &velocity, sizeof velocity);
    __builtin_memcpy(sum.spin, &spin, sizeof spin);
  }
  std::uint64_t all = 0;
  for (std::uint32_t k = task.from; k < task.to; ++k) all += static_cast<std::uint64_t>(task.out[k].touches);
  task.stats->pairs += all;
  if (task.sums_alone) return;
  for (std::uint32_t k = task.from; k < task.to; ++k) {
    Four own = load_four(task.grains[k].velocity);
    own[3] = 0;
    const Four velocity = own + load_four(task.out[k].velocity);
    const Four spin = load_four(task.grains[k].spin) + load_four(task.out[k].spin);
    __builtin_memcpy(task.out[k].velocity, &velocity, sizeof velocity);
    __builtin_memcpy(task.out[k].spin, &spin, sizeof spin);
  }
}

/// Writes what was computed to the columns of the store.
inline void give_pushes(const interactions::GiveTask& task) {
  float* const* const to = task.to;
  for (std::uint32_t k = task.from; k < task.last; ++k) {
    const std::uint32_t i = task.order[k];
    if (i >= task.own || (task.chosen != nullptr && task.chosen[i] == 0)) continue;
    const GrainPush& push = task.out[k];
    for (int c = 0; c < 3; ++c) to[c][i] = push.velocity[c], to[3 + c][i] = push.spin[c];
    const bool adds = task.adds_to != nullptr ? task.adds_to[i] != 0 : task.adds;
    to[6][i] = adds ? to[6][i] + push.touches : push.touches;
  }
}

}  // namespace motes::MOTES_ISA
