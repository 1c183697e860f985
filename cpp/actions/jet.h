// jet: v += a dt where the first shape holds the particle, with a drawn uniformly from the second (McAllister's Jet).
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

inline void jet(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  // Two passes: one switch over shapes inside another would be compiled for every pair of them.
  std::int32_t inside[particles::kBlock + particles::kPadding];
  visit(p.shape[0], [&](const auto& shape) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) store_mask(inside + i, shape.contains(load3(b, kPositionAt, i)));
  });
  const Stream stream = stream_of(s);
  visit(p.shape[1], [&](const auto& accelerations) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < b.count; i += kLanes) {
      const Mask mask = load_mask(inside + i);
      if (!any(mask)) continue;
      Draws draws(stream, b.ids + i);
      const Floats3 v = load3(b, kVelocityAt, i);
      store3(b, kVelocityAt, i, select(mask, v + accelerations.sample(draws) * all(s.dt), v));
    }
  });
}

}  // namespace motes::MOTES_ISA
