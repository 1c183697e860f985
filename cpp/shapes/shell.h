// What cylinders and cones share: the space between two walls around an axis, closed by a plane at each end.
//
// Along a straight path each of the three regions (between the planes, within the outer wall, within the bore) is one
// interval. The hit is the first interval end of the material that lies ahead, so there is no seam between wall and cap
// through which a fast particle could slip.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

/// A wall around the axis: its radius at the axis's start, and how much the radius grows per metre along the axis.
struct Wall {
  float start, slope;
};

/// The part of a path between `from` and `to`; empty where from > to.
struct PathInterval {
  Floats from, to;
};

inline constexpr float kEndless = __builtin_inff();
MOTES_INLINE PathInterval nowhere() { return {all(kEndless), all(-kEndless)}; }
MOTES_INLINE PathInterval select(Mask mask, PathInterval yes, PathInterval no) {
  return {select(mask, yes.from, no.from), select(mask, yes.to, no.to)};
}

struct Shell {
  const shapes::Shape* shape;
  Float3 start, axis, u, v;
  float length;
  Wall outer, inner;
  bool bored, thin;  // thin: both walls coincide

  static MOTES_INLINE Shell from(const shapes::Shape& s, Wall outer, Wall inner) {
    const auto axial = s.as<shapes::numbers::axial>();
    const Float3 start = of(axial.start), whole = minus(of(axial.end), start);
    const Float3 axis = unit(whole);
    const Basis basis = basis_of(axis);
    const bool bored = inner.start > 0.0f || inner.slope > 0.0f;
    const bool thin = inner.start == outer.start && inner.slope == outer.slope;
    return {&s, start, axis, basis.u, basis.v, __builtin_sqrtf(dot(whole, whole)), outer, inner, bored, thin};
  }

  MOTES_INLINE Mask contains(Floats3 p) const {
    if (thin) return Mask{};  // a surface: rounding would decide which side of it a sample is on
    const Rough at = rough(p);
    const Mask inside = at.between & at.side.within & at.bore.beyond;
    const Mask outside = at.below | at.above | at.side.beyond | at.bore.within;
    return any(~(inside | outside)) ? contains_exactly(*shape, p) : inside;
  }

  /// Returns the point at the fraction `along` (0..1) of the axis, at a distance from it, after `turn` (0..1) of a turn
  /// around it.
  MOTES_INLINE Floats3 point(Floats along, Floats distance, Floats turn) const {
    Floats cosine, sine;
    cos_sin_turn(turn, cosine, sine);
    const Floats3 across = all3(u) * (distance * cosine) + all3(v) * (distance * sine);
    return all3(start) + all3(axis) * (along * length) + across;
  }

  /// Returns false where a path stays clear of the surface.
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const {
    const Rough before = rough(p), after = rough(to);
    const AxialPoint by = split(to - p);
    // The regions below an end, above one, within a wall and within the bore are convex: a path between two places of
    // one stays in it.
    const Mask beyond = (before.below & after.below) | (before.above & after.above);
    const Mask within = before.side.within & after.side.within;
    const Mask clear = beyond | past(before, after, before.side.most, after.side.most, by);
    if (thin) return ~(clear | within);
    const Mask inside = within & before.between & after.between;
    if (!bored) return ~(clear | inside);
    const Mask beside = past(before, after, before.bore.most, after.bore.most, by);
    return ~(clear | (inside & beside) | (before.bore.within & after.bore.within));
  }

  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const {
    const AxialPoint at = place(p);
    const AxialPoint by = split(path);
    const PathInterval caps = between_caps(at, by);
    const PathInterval side = within(outer, at, by);
    const PathInterval bore = bored ? within(inner, at, by) : nowhere();
    const Border border = first_border(caps, side, bore);
    const Mask mask = border.mask & (border.part <= 1.0f);
    const Floats part = select(mask, border.part, Floats{});
    const Floats3 out =
        wall_normal(at.across + by.across * part, select(border.of_bore, all(inner.slope), all(outer.slope)));
    const Floats3 from_wall = out * select(border.outward, all(1.0f), all(-1.0f));
    const Floats3 from_cap = all3(axis) * select(by.height > 0.0f, all(-1.0f), all(1.0f));
    return {mask, part, select(border.of_cap, from_cap, from_wall)};
  }

 private:
  /// A point, or a path, split into its components along the axis and across it.
  struct AxialPoint {
    Floats height;
    Floats3 across;
  };
  MOTES_INLINE AxialPoint split(Floats3 d) const {
    const Floats height = dot(d, all3(axis));
    return {height, d - all3(axis) * height};
  }
  MOTES_INLINE AxialPoint place(Floats3 p) const { return split(p - all3(start)); }

  /// The side of a wall that a place is on; if neither is true, rounding decides.
  struct WallSide {
    Mask within, beyond;
    Floats most;  // the radius there, and what rounding may add
  };
  struct Rough {
    AxialPoint at;
    Floats across2;
    Mask below, above, between;  // relative to the ends of the axis
    WallSide side, bore;
  };
  MOTES_INLINE Rough rough(Floats3 p) const {
    const Floats3 d = p - all3(start);
    const AxialPoint at = split(d);
    const Floats across2 = dot(at.across, at.across);
    const Floats rounding = (abs(d.x) + abs(d.y) + abs(d.z)) * kRounding;
    const float far = length * (1.0f + kRounding), near = length * (1.0f - kRounding);
    const WallSide none{Mask{}, ~Mask{}, Floats{}};
    return {at,
            across2,
            at.height<-rounding, at.height - rounding> far,
            (at.height > rounding) & (at.height + rounding < near),
            wall_side(outer, at, across2, rounding),
            bored ? wall_side(inner, at, across2, rounding) : none};
  }
  static MOTES_INLINE WallSide wall_side(Wall wall, const AxialPoint& at, Floats across2, Floats rounding) {
    const Floats radius = wall.start + wall.slope * at.height;
    const Floats unsure = rounding * (2.0f + 2.0f * wall.slope) + abs(radius) * kRounding;
    const Floats least = radius - unsure, most = max(radius, Floats{}) + unsure;
    return {(least > 0.0f) & (across2 < least * least), across2 > most * most, most};
  }
  /// Returns whether a path stays further from the axis than the larger of two radii.
  static MOTES_INLINE Mask past(const Rough& before, const Rough& after, Floats radius, Floats other,
                                const AxialPoint& by) {
    const Floats most = max(radius, other), most2 = most * most;
    const Floats a = dot(by.across, by.across), b = dot(before.at.across, by.across);
    const Mask nearest_at_end = (b >= 0.0f) | (a + b <= 0.0f);
    const Floats between = before.across2 * a - b * b;
    return (before.across2 > most2) & (after.across2 > most2) &
           (nearest_at_end | (between > a * (most2 + before.across2 * (2.0f * kRounding))));
  }

  MOTES_INLINE PathInterval between_caps(const AxialPoint& at, const AxialPoint& by) const {
    const Mask still = by.height == 0.0f;
    const Floats inverse = all(1.0f) / select(still, all(1.0f), by.height);
    const Floats to_start = -at.height * inverse;
    const Floats to_end = (length - at.height) * inverse;
    const Mask inside = (at.height >= 0.0f) & (at.height <= length);
    const PathInterval standing = select(inside, PathInterval{all(-kEndless), all(kEndless)}, nowhere());
    return select(still, standing, {min(to_start, to_end), max(to_start, to_end)});
  }

  /// Returns the part of a path where |across| < radius: a s^2 + 2 b s + c < 0 for the fraction s of the path. Where
  /// the path is steeper than a cone's side (a < 0), it is inside the cone beyond one root, and inside the cone's
  /// mirror image beyond the other.
  static MOTES_INLINE PathInterval within(Wall wall, const AxialPoint& at, const AxialPoint& by) {
    const Floats radius = wall.start + wall.slope * at.height;
    const Floats growth = wall.slope * by.height;
    const Floats a = (dot(by.across, by.across) - growth * growth) + 0.0f;  // never -0: its inverse would be -infinite
    const Floats b = dot(at.across, by.across) - radius * growth;
    const Floats c = dot(at.across, at.across) - radius * radius;
    const Floats square = b * b - a * c;
    const Floats root = sqrt(max(square, Floats{}));
    // The roots are q / a and c / q: nothing cancels.
    const Floats q = select(b > 0.0f, -(b + root), root - b);
    const Mask flat = q == 0.0f;
    const Floats one = q / select(flat, all(1.0f), a);
    const Floats other = c / select(flat, all(1.0f), q);
    const Floats first = min(one, other), last = max(one, other);
    const PathInterval steep =
        select(by.height > 0.0f, PathInterval{last, all(kEndless)}, PathInterval{all(-kEndless), first});
    const PathInterval still = select(c < 0.0f, PathInterval{all(-kEndless), all(kEndless)}, nowhere());
    // From within, the wall can only seem to be nowhere because squares of tiny numbers underflow.
    const PathInterval met = select(a < 0.0f, steep, select(square > 0.0f, PathInterval{first, last}, still));
    return select(flat, still, met);
  }

  /// An end of an interval of the material.
  struct Border {
    Mask mask;
    Floats part;
    Mask of_cap, of_bore;
    Mask outward;  // the face that is hit points away from the axis
  };

  /// Returns the first border ahead. The material is between caps and side, without the bore: one interval before the
  /// bore and one behind it.
  static MOTES_INLINE Border first_border(const PathInterval& caps, const PathInterval& side,
                                          const PathInterval& bore) {
    const PathInterval solid{max(caps.from, side.from), min(caps.to, side.to)};
    const Mask hollow = bore.from <= bore.to;
    const Floats bore_from = select(hollow, bore.from, all(kEndless));
    const Floats bore_to = select(hollow, bore.to, all(kEndless));
    const PathInterval before{solid.from, min(solid.to, bore_from)};
    const PathInterval behind{max(solid.from, bore_to), solid.to};
    const Mask enters_before = (before.from <= before.to) & (before.from >= 0.0f);
    const Mask leaves_before = (before.from <= before.to) & (before.from < 0.0f) & (before.to > 0.0f);
    const Mask near = enters_before | leaves_before;
    const Mask enters_behind = ~near & (behind.from <= behind.to) & (behind.from >= 0.0f);
    const Mask leaves_behind = ~near & (behind.from <= behind.to) & (behind.from < 0.0f) & (behind.to > 0.0f);
    const Mask enters = enters_before | enters_behind;
    const Mask leaves = leaves_before | leaves_behind;
    const PathInterval ahead = select(near, before, behind);
    const Mask of_bore = (leaves_before & (bore_from < solid.to)) | (enters_behind & (bore_to > solid.from));
    const Mask of_cap = ~of_bore & ((enters & (caps.from > side.from)) | (leaves & (caps.to < side.to)));
    return {enters | leaves, select(enters, ahead.from, ahead.to), of_cap, of_bore,
            (of_bore & leaves) | (~of_bore & enters)};
  }

  /// Returns the outward normal of a wall at offset `across` from the axis.
  MOTES_INLINE Floats3 wall_normal(Floats3 across, Floats slope) const {
    const Floats radius = sqrt(max(dot(across, across), all(1e-30f)));
    const Floats scale = all(1.0f) / sqrt(1.0f + slope * slope);
    return (across * (all(1.0f) / radius) - all3(axis) * slope) * scale;
  }
};

}  // namespace motes::MOTES_ISA
