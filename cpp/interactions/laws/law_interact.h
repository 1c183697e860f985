// interact: a law that the script writes as expressions. They run over hundreds of pairs at a time: pairs within reach
// are found and their columns gathered, then each operation is a loop over them.
#pragma once

#include "expressions/operate.h"
#include "interactions/sweep.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {

/// Pairs within reach of some targets.
struct PairBatch {
  static constexpr std::uint32_t kMost = interactions::kFormulaPairs, kRoom = kMost + 2 * kLanes;

  std::uint32_t count = 0;
  alignas(64) std::uint32_t pair[kRoom], target[kRoom], source[kRoom];
};

MOTES_INLINE Floats3 gather3(const float* const (&column)[3], Uints at) {
  return {gather(column[0], (Ints)at), gather(column[1], (Ints)at), gather(column[2], (Ints)at)};
}

/// Adds the target's pairs within reach from `pair` on, as many as fit; returns the next pair.
MOTES_INLINE std::uint32_t find_pairs(const interactions::ScriptedTask& task, std::uint32_t i, std::uint32_t pair,
                                      PairBatch& batch) {
  const Floats3 at{all(task.at[0][i]), all(task.at[1][i]), all(task.at[2][i])};
  const std::uint32_t end = task.pairs.begin[i + 1], before = batch.count;
  for (; pair < end && batch.count < PairBatch::kMost; pair += kLanes) {
    const Mask here = first_lanes(end - pair);
    const Uints j = load_uints(task.pairs.second + pair) & (Uints)here;
    const Floats3 r = gather3(task.at, j) - at;
    const Mask near = (dot(r, r) < task.reach2) & here;
    squeeze(batch.source + batch.count, j, near);
    batch.count += static_cast<std::uint32_t>(squeeze(batch.pair + batch.count, lane_numbers() + pair, near));
  }
  for (std::uint32_t k = before; k < batch.count; ++k) batch.target[k] = i;
  return pair < end ? pair : end;
}

/// Computes the distance and the unit vector from target to source; the vector is 0 if both are at the same position.
MOTES_INLINE void compute_shared(const interactions::ScriptedTask& task, const PairBatch& batch) {
  constexpr std::size_t kPlane = interactions::kFormulaPlane;
  for (std::uint32_t k = 0; k < batch.count; k += kLanes) {
    const Uints here = (Uints)first_lanes(batch.count - k);
    const Floats3 r =
        gather3(task.at, load_uints(batch.source + k) & here) - gather3(task.at, load_uints(batch.target + k) & here);
    const Floats d = sqrt(dot(r, r));
    const Floats3 normal = only(d > 0.0f, r * (1.0f / d));
    store(task.shared + k, d);
    store(task.shared + kPlane + k, normal.x);
    store(task.shared + 2 * kPlane + k, normal.y);
    store(task.shared + 3 * kPlane + k, normal.z);
  }
}

/// Returns the address of a number of a pair's state; each part holds kStateNumbers of them.
MOTES_INLINE float* state_of(const interactions::PairsView& pairs, std::uint32_t pair, int number) {
  static_assert(sizeof(interactions::PairState) == (interactions::kStateNumbers + 2) * sizeof(float));
  interactions::PairState* state = pairs.state + static_cast<std::size_t>(pair) * pairs.parts;
  return reinterpret_cast<float*>(state + number / interactions::kStateNumbers) + number % interactions::kStateNumbers;
}

MOTES_INLINE bool remembers(const interactions::ScriptedTask& task, std::uint32_t pair) {
  return task.pairs.state[static_cast<std::size_t>(pair) * task.pairs.parts].step + 1 == task.now;
}

MOTES_INLINE void gather_leaf(const interactions::ScriptedTask& task, const interactions::LeafSource& leaf,
                              const PairBatch& batch, float* to) {
  using How = interactions::LeafSource::How;
  if (leaf.how == How::same) return fill(to, leaf.value, batch.count);
  if (leaf.how == How::state) {
    for (std::uint32_t k = 0; k < batch.count; ++k) {
      to[k] = remembers(task, batch.pair[k]) ? *state_of(task.pairs, batch.pair[k], leaf.number) : 0.0f;
    }
    return;
  }
  const std::uint32_t* at = leaf.how == How::other ? batch.source : batch.target;
  for (std::uint32_t k = 0; k < batch.count; k += kLanes) {
    Uints place = load_uints(at + k) & (Uints)first_lanes(batch.count - k);
    if (leaf.how == How::own_by_index)
      place = (Uints)gather(reinterpret_cast<const float*>(task.targets.order), (Ints)place);
    store(to + k, gather(leaf.column, (Ints)place));
  }
}

/// Stores the next states; a number that would not be finite keeps its previous value.
MOTES_INLINE void keep_states(const interactions::ScriptedTask& task, const PairBatch& batch) {
  for (std::uint32_t k = 0; k < batch.count; ++k) {
    const bool known = remembers(task, batch.pair[k]);
    for (int number = 0; number < task.state_count; ++number) {
      float* state = state_of(task.pairs, batch.pair[k], number);
      const float before = known ? *state : 0.0f;
      const float next = task.states[number] >= 0 ? task.plane[task.states[number]][k] : before;
      *state = __builtin_fabsf(next) <= __FLT_MAX__ ? next : before;
    }
    for (std::uint32_t part = 0; part < task.pairs.parts; ++part) {
      task.pairs.state[static_cast<std::size_t>(batch.pair[k]) * task.pairs.parts + part].step = task.now;
    }
  }
}

/// Computes a batch and adds up each target's finite values in the order of its pairs.
MOTES_INLINE void run_batch(const interactions::ScriptedTask& task, PairBatch& batch) {
  if (task.shares) compute_shared(task, batch);
  for (std::size_t leaf = 0; leaf < task.leaf_count; ++leaf) {
    if (task.leaves[leaf].how == interactions::LeafSource::How::shared) continue;
    gather_leaf(task, task.leaves[leaf], batch, task.plane[leaf]);
  }
  run_steps(task.steps, task.step_count, task.plane, batch.count,
            [](const expressions::FormulaStep&, const float* const*, float*) __attribute__((always_inline)) {});
  if (task.state_count > 0) keep_states(task, batch);
  for (std::size_t s = 0; s < task.sum_count; ++s) {
    float* value = task.plane[task.sums[s]];
    each(batch.count, [&](std::size_t k) __attribute__((always_inline)) {
      const Floats v = load(value + k);
      store(value + k, only(abs(v) <= __FLT_MAX__, v));
    });
  }
  for (std::uint32_t k = 0; k < batch.count; ++k) {
    const std::uint32_t i = batch.target[k];
    for (std::size_t s = 0; s < task.sum_count; ++s) task.out[s][i] += task.plane[task.sums[s]][k];
  }
  task.stats->pairs += batch.count;
  batch.count = 0;
}

inline void scripted(const interactions::ScriptedTask& task) {
  const std::uint32_t first = task.targets.rows[task.first_row].first;
  const std::uint32_t last = task.targets.rows[task.last_row].first;
  for (std::size_t s = 0; s < task.sum_count; ++s) {
    __builtin_memset(task.out[s] + first, 0, (last - first) * sizeof(float));
  }
  write_constants(task.constants, task.constant_count, task.plane, PairBatch::kMost + kLanes, task.time);
  PairBatch batch;
  for (std::uint32_t i = first; i < last; ++i) {
    if (task.chosen != nullptr && task.pairs.begin[i] < task.pairs.begin[i + 1] &&
        task.chosen[task.targets.order[i]] == 0)
      continue;
    for (std::uint32_t pair = task.pairs.begin[i]; pair < task.pairs.begin[i + 1];) {
      pair = find_pairs(task, i, pair, batch);
      if (batch.count >= PairBatch::kMost) run_batch(task, batch);
    }
  }
  if (batch.count > 0) run_batch(task, batch);
}

namespace laws {
inline constexpr interactions::Law interact = {
    .reach = [](const double* recorded) { return actions::read_numbers<numbers::interact>(recorded).radius; },
    .remembers = true,
    .between_systems = true,
};
}  // namespace laws

}  // namespace motes::MOTES_ISA
