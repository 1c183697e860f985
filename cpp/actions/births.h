// Attributes of newborn particles: values drawn from distributions, and births spread over the step.
#pragma once

#include "actions/kernels.h"
#include "actions/lanes.h"
#include "shapes/mesh.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats3 draw_one(const actions::Distribution& d, Draws& draws) {
  const Floats3 first = all3(d.first);
  Floats3 second = all3(d.second);
  const Uints4 w = draws.bits();
  Floats3 n{};
  if (d.kind == actions::Distribution::Kind::uniform) {
    n = {unit(w.a), unit(w.b), unit(w.c)};
    second = second - first;
  } else {
    Floats unused;
    normal_pair(w.a, w.b, n.x, n.y);
    normal_pair(w.c, w.d, n.z, unused);
  }
  if (d.alike) n = {n.x, n.x, n.x};
  return first + Floats3{second.x * n.x, second.y * n.y, second.z * n.z};
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

// Draws the normal or colour of the mesh d.shape at the points where the same draws placed the particles.
inline void draw_on_surface(const actions::Distribution& d, const actions::Step& s, const particles::Ids& ids,
                            std::size_t count, float* const* planes, int width) {
  const MeshLanes mesh = MeshLanes::from(d.shape);
  if (d.kind == actions::Distribution::Kind::surface_color) {
    fill(s, ids, count, planes, width,
         [&](Draws& draws) __attribute__((always_inline)) { return mesh.sample_color(draws); });
  } else {
    fill(s, ids, count, planes, width,
         [&](Draws& draws) __attribute__((always_inline)) { return mesh.sample_normal(draws) * d.first[0]; });
  }
}

inline void draw(const actions::Distribution& d, const actions::Step& s, const particles::Ids& ids, std::size_t count,
                 float* const* planes, int width) {
  using Kind = actions::Distribution::Kind;
  if (d.kind == Kind::rotation) {
    draw_rotations(s, ids, count, planes);
  } else if (d.kind == Kind::value) {
    fill(s, ids, count, planes, width, [&](Draws&) __attribute__((always_inline)) { return all3(d.first); });
  } else if (d.of_surface()) {
    draw_on_surface(d, s, ids, count, planes, width);
  } else if (d.kind == Kind::shape) {
    visit(d.shape, [&](const auto& shape) __attribute__((always_inline)) {
      fill(s, ids, count, planes, width,
           [&](Draws& draws) __attribute__((always_inline)) { return shape.sample(draws); });
    });
  } else {
    fill(s, ids, count, planes, width, [&](Draws& draws) __attribute__((always_inline)) { return draw_one(d, draws); });
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
