// Attributes of newborn particles: values drawn from distributions, and births spread over the step.
#pragma once

#include "actions/kernels.h"
#include "actions/lanes.h"
#include "shapes/mesh.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats3 draw_one(const actions::distributions::Uniform& uniform, Draws& draws) {
  const Floats3 low = all3(uniform.low), span = all3(uniform.high) - low;
  const Uints4 w = draws.bits();
  Floats3 n{unit(w.a), unit(w.b), unit(w.c)};
  if (uniform.alike) n = {n.x, n.x, n.x};
  return low + Floats3{span.x * n.x, span.y * n.y, span.z * n.z};
}

MOTES_INLINE Floats3 draw_one(const actions::distributions::Normal& normal, Draws& draws) {
  const Floats3 sigma = all3(normal.sigma);
  const Uints4 w = draws.bits();
  Floats3 n{};
  Floats unused;
  normal_pair(w.a, w.b, n.x, n.y);
  normal_pair(w.c, w.d, n.z, unused);
  if (normal.alike) n = {n.x, n.x, n.x};
  return all3(normal.mean) + Floats3{sigma.x * n.x, sigma.y * n.y, sigma.z * n.z};
}

template <class Sample>
MOTES_INLINE void fill(const actions::Step& s, const particles::Ids& ids, std::size_t count, float* const* planes,
                       int width, const Sample& sample) {
  for_draws<false>(draws_of(s), ids, count, [&](std::size_t i, Draws& draws) __attribute__((always_inline)) {
    const Floats3 v = sample(draws);
    store(planes[0] + i, v.x);
    if (width == 1) return;
    store(planes[1] + i, v.y);
    store(planes[2] + i, v.z);
  });
}

/// Draws uniformly distributed orientations: four normal numbers, scaled to length 1.
inline void draw_rotations(const actions::Step& s, const particles::Ids& ids, std::size_t count, float* const* planes) {
  for_draws<false>(draws_of(s), ids, count, [&](std::size_t i, Draws& draws) __attribute__((always_inline)) {
    const Uints4 w = draws.bits();
    Rotations q;
    normal_pair(w.a, w.b, q.x, q.y);
    normal_pair(w.c, w.d, q.z, q.w);
    q = unit(q);
    const Floats numbers[4] = {q.x, q.y, q.z, q.w};
    for (int c = 0; c < 4; ++c) store(planes[c] + i, numbers[c]);
  });
}

inline void draw(const actions::Distribution& distribution, const shapes::Shape* birthplace, const actions::Step& s,
                 const particles::Ids& ids, std::size_t count, float* const* planes, int width) {
  using namespace actions::distributions;
  const auto fill_by = [&](const auto& sample)
                           __attribute__((always_inline)) { fill(s, ids, count, planes, width, sample); };
  if (std::holds_alternative<AnyRotation>(distribution)) {
    draw_rotations(s, ids, count, planes);
  } else if (const auto* value = std::get_if<Value>(&distribution)) {
    fill_by([&](Draws&) __attribute__((always_inline)) { return all3(value->number); });
  } else if (const auto* in = std::get_if<InShape>(&distribution)) {
    visit(in->shape, [&](const auto& shape) __attribute__((always_inline)) {
      fill_by([&](Draws& draws) __attribute__((always_inline)) { return shape.sample(draws); });
    });
  } else if (const auto* uniform = std::get_if<Uniform>(&distribution)) {
    fill_by([&](Draws& draws) __attribute__((always_inline)) { return draw_one(*uniform, draws); });
  } else if (const auto* normal = std::get_if<Normal>(&distribution)) {
    fill_by([&](Draws& draws) __attribute__((always_inline)) { return draw_one(*normal, draws); });
  } else {  // of the surface, at the points where the same draws placed the particles
    const MeshLanes mesh = MeshLanes::from(*birthplace);
    if (const auto* along = std::get_if<AlongNormal>(&distribution)) {
      fill_by([&](Draws& draws) __attribute__((always_inline)) { return mesh.sample_normal(draws) * along->length; });
    } else {
      fill_by([&](Draws& draws) __attribute__((always_inline)) { return mesh.sample_color(draws); });
    }
  }
}

inline void spread(const actions::Block& positions, float* const* before, float start, float end,
                   const actions::Step& s) {
  const auto place = [&](std::size_t i, Draws& draws) __attribute__((always_inline)) {
    const Floats part = end - unit(draws.bits().a) * (end - start);
    for (int c = 0; c < 3; ++c) {
      const Floats from = load(before[c] + i), to = load(positions.component[c] + i);
      store(positions.component[c] + i, from + (to - from) * part);
    }
  };
  for_draws<false>(draws_of(s), positions.ids, positions.count, place);
}

inline void jitter(const actions::Block& b, const actions::Step& s) {
  for_draws<false>(draws_of(s), b.ids, b.count, [&](std::size_t i, Draws& draws) __attribute__((always_inline)) {
    const Floats passed = unit(draws.bits().a) * s.dt;
    const Floats3 from = load3(b, kPositionAt, i);
    const Floats3 to = from + load3(b, kVelocityAt, i) * passed;
    store3(b, kPositionAt, i, select(finite(to), to, from));
    store(b.component[kAgeAt] + i, load(b.component[kAgeAt] + i) + passed);
  });
}

}  // namespace motes::MOTES_ISA
