// jet: v += a dt where the first shape contains the particle; a is drawn uniformly from the second (McAllister's Jet).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void jet(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  // Two passes, since nested dispatch over shapes would be compiled for every pair of them.
  std::int32_t inside[particles::kBlock + particles::kPadding];
  Mask some = Mask{};
  visit(p.shape[0], [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Mask mask = shape.contains(load3(b, kPositionAt, i));
      store_mask(inside + i, mask);
      some |= mask;
    }
  });
  if (!any(some)) return;
  particles::DrawKeys& keys = draws_of(s);
  const particles::DrawKey first = keys.first();
  visit(p.shape[1], [&](const auto& accelerations) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Mask mask = load_mask(inside + i);
      if (!any(mask)) continue;
      Draws draws(keys, random_bits(first, b.ids, i), b.ids, i);
      const Floats3 v = load3(b, kVelocityAt, i);
      store3(b, kVelocityAt, i, select(mask, v + accelerations.sample(draws) * all(s.dt), v));
    }
  });
}

}  // namespace motes::MOTES_ISA
