// What bounces note of their hits in columns: how many in this frame, the normal of the last one, and where it was.
//
// landing = x, y, z of the last hit and the stamp of its sub-step; stamp 0 if the surface moved there. `rest` puts
// particles at their landing: a place on their side of the surface, at most a skin (bounce_path.h) above it.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats largest(Floats3 p) { return max(max(abs(p.x), abs(p.y)), abs(p.z)); }

/// The hits of a vector of particles in one bounce. `still`: the surface did not move at the last hit.
struct Hits {
  Floats count;
  Floats3 normal, place;
  Mask still;
};

/// The hits of half a vector of particles.
struct HalfHits {
  Doubles count{};
  Doubles3 normal{}, place{};

  MOTES_INLINE void add(Longs mask, Doubles3 its_normal, Doubles3 its_place) {
    count = count + select(mask, all_doubles(1.0), Doubles{});
    normal = select(mask, its_normal, normal);
    place = select(mask, its_place, place);
  }
};

MOTES_INLINE Hits join(const HalfHits& low, const HalfHits& high) {
  return {join(low.count, high.count), join(low.normal, high.normal), join(low.place, high.place), ~Mask{}};
}

/// Returns the number, other than 0, by which a sub-step is told from the others of its frame.
MOTES_INLINE float stamp_of(const actions::Step& s) { return static_cast<float>(1 + (s.step & 0xffffu)); }

/// A particle that has moved less than this part of its largest coordinate before its hit has landed where it started,
/// so that what rests stays in place to the last bit.
inline constexpr float kUnmoved = 0x1p-16f;

/// Adds hits to the columns of the lanes of `mask`. `start`: where the particles were before the step.
__attribute__((noinline)) inline void note_hits(const actions::Block& b, std::size_t i, const Mask& mask,
                                                const Hits& hits, const Floats3& start) {
  float* const count = b.component[kHitAt] + i;
  float* const stamp = b.component[kLandingAt + 3] + i;
  store(count, load(count) + only(mask, hits.count));
  store3(b, kHitNormalAt, i, select(mask, hits.normal, load3(b, kHitNormalAt, i)));
  const Mask unmoved = largest(hits.place - start) <= largest(start) * kUnmoved;
  store3(b, kLandingAt, i, select(mask, select(unmoved, start, hits.place), load3(b, kLandingAt, i)));
  store(stamp, select(mask, only(hits.still, all(b.stamp)), load(stamp)));
}

}  // namespace motes::MOTES_ISA
