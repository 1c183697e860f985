// law: an action that the script defines. The values of its expressions are added to attributes or replace them.
#pragma once

#include "actions/evaluate.h"

namespace motes::MOTES_ISA {

/// Adds finite values to a column: rates times `dt` (seconds), or changes (dt = 1).
MOTES_INLINE void add_finite(float* column, const float* value, std::size_t count, float dt) {
  each(count, [&](std::size_t i) __attribute__((always_inline)) {
    const Floats v = load(value + i) * dt;
    store(column + i, load(column + i) + only(abs(v) <= __FLT_MAX__, v));
  });
}

/// Runs a law. All values are computed from the particle as it was before the action.
inline void law(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const actions::LawCode& law = *p.bound.law;
  for (std::size_t c = 0; c < law.columns; ++c) law.plane[c] = b.component[c];
  write_constants(law.constants, law.constant_count, law.plane, b.count, static_cast<float>(s.time));
  run_steps(law.steps, law.step_count, law.plane, b.count,
            [&](const expressions::FormulaStep& step, const float* const* position, float* to)
                __attribute__((always_inline)) {
                  if (step.op == expressions::Op::id) return write_ids(b.ids, step.index, b.count, to);
                  inside(p.shape[step.index], b.count, position, to);
                });
  for (std::size_t k = 0; k < law.outcome_count; ++k) {
    const actions::LawResult& outcome = law.outcomes[k];
    float* column = b.component[outcome.component];
    const float* value = law.plane[outcome.plane];
    if (outcome.adds) {
      add_finite(column, value, b.count, outcome.rate ? s.dt : 1.0f);
    } else {
      keep_finite(column, value, b.count);
    }
  }
}

}  // namespace motes::MOTES_ISA
