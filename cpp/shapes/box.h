// An axis-aligned box.
#pragma once

#include "shapes/clear.h"

namespace motes::MOTES_ISA {

struct ExactBox;  // in exact_solid.h

struct BoxLanes {
  static constexpr bool kDrawsTogether = true;
  using Exact = ExactBox;
  Float3 low, high;

  static MOTES_INLINE BoxLanes from(const shapes::Shape& s) {
    const auto box = s.as<shapes::numbers::box>();
    return {of(box.low), of(box.high)};
  }
  MOTES_INLINE Mask contains(Floats3 p) const {
    return (p.x >= low.x) & (p.x <= high.x) & (p.y >= low.y) & (p.y <= high.y) & (p.z >= low.z) & (p.z <= high.z);
  }
  MOTES_INLINE Floats3 sample(Draws& draws) const {
    const Uints4 bits = draws.bits();
    const Float3 size = minus(high, low);
    // Divided by a power of two once, not for each particle: the same bits, unless the box is smaller than 1e-30 m.
    const Float3 step{size.x * 0x1p-24f, size.y * 0x1p-24f, size.z * 0x1p-24f};
    return {low.x + step.x * whole(bits.a), low.y + step.y * whole(bits.b), low.z + step.z * whole(bits.c)};
  }

  /// Returns false where a path stays clear of the faces.
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const {
    const auto beside = [](Floats a, Floats b, float lo, float hi)
                            __attribute__((always_inline)) { return (max(a, b) < lo) | (min(a, b) > hi); };
    const Mask outside =
        beside(p.x, to.x, low.x, high.x) | beside(p.y, to.y, low.y, high.y) | beside(p.z, to.z, low.z, high.z);
    return ~(outside | (contains(p) & contains(to)));
  }

  /// Returns a bound on paths that stay clear of the faces.
  MOTES_INLINE Clear clear() const { return {low, high}; }

  /// Returns where a path from outside enters, or one from inside leaves.
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const {
    const Mask inside = contains(p);
    Floats enter = all(-1.0f), leave = all(2.0f);
    Floats3 enter_normal{Floats{}, Floats{}, Floats{}}, leave_normal = enter_normal;
    Mask apart = Mask{};
    slab(p.x, path.x, low.x, high.x, enter, leave, apart, enter_normal, leave_normal, 0);
    slab(p.y, path.y, low.y, high.y, enter, leave, apart, enter_normal, leave_normal, 1);
    slab(p.z, path.z, low.z, high.z, enter, leave, apart, enter_normal, leave_normal, 2);
    const Mask from_outside = ~inside & ~apart & (enter <= leave) & (enter >= 0.0f) & (enter <= 1.0f);
    const Mask from_inside = inside & (leave < 1.0f);
    const Mask mask = from_outside | from_inside;
    const Floats part = max(select(inside, leave, enter), Floats{});
    return {mask, select(mask, part, Floats{}), select(inside, leave_normal, enter_normal)};
  }

 private:
  static MOTES_INLINE void set_axis(Floats3& v, Mask where, int axis, Floats value) {
    v = {select(where, axis == 0 ? value : Floats{}, v.x), select(where, axis == 1 ? value : Floats{}, v.y),
         select(where, axis == 2 ? value : Floats{}, v.z)};
  }

  static MOTES_INLINE void slab(Floats p, Floats d, float lo, float hi, Floats& enter, Floats& leave, Mask& apart,
                                Floats3& enter_normal, Floats3& leave_normal, int axis) {
    const Mask still = d == 0.0f;
    apart |= still & ((p < lo) | (p > hi));
    const Floats inverse = all(1.0f) / select(still, all(1.0f), d);
    const Mask rising = d > 0.0f;
    const Floats to_low = (lo - p) * inverse;
    const Floats to_high = (hi - p) * inverse;
    const Floats near = select(rising, to_low, to_high);
    const Floats far = select(rising, to_high, to_low);
    const Floats back = select(rising, all(-1.0f), all(1.0f));
    const Mask later = ~still & (near > enter);
    enter = select(later, near, enter);
    set_axis(enter_normal, later, axis, back);
    const Mask sooner = ~still & (far < leave);
    leave = select(sooner, far, leave);
    set_axis(leave_normal, sooner, axis, back);
  }
};

}  // namespace motes::MOTES_ISA
