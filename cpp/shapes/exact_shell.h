// Exact tests of cylinders and cones: see shapes/shell.h.
#pragma once

#include "shapes/exact_met.h"

namespace motes::MOTES_ISA {

struct ExactShell {
  /// A wall around the axis: its radius at the axis's start, and how much it grows per metre along the axis.
  struct Wall {
    double start, slope;
  };

  Double3 start, axis;
  double length;
  Wall outer, inner;
  bool bored, thin;

  static MOTES_INLINE ExactShell of(const shapes::Shape& s) {
    const auto axial = s.as<shapes::numbers::axial>();
    const Double3 start = doubles_of(axial.start), whole = doubles_of(axial.end) - start;
    const double height = motes::MOTES_ISA::length(whole), radius = axial.radius, inner = axial.inner_radius;
    const bool thin = radius == inner, bored = inner > 0.0;
    const Double3 axis = whole * (1.0 / height);
    if (s.kind == shapes::Kind::cylinder) return {start, axis, height, {radius, 0.0}, {inner, 0.0}, bored, thin};
    return {start, axis, height, {0.0, radius / height}, {0.0, inner / height}, bored, thin};
  }

  MOTES_INLINE Longs contains(Doubles3 p) const { return thin ? Longs{} : contains(split(p - all3(start))); }

  MOTES_INLINE Met meet(Doubles3 from, Doubles3 to) const {
    const Doubles3 way = to - from;
    const AxialPoint at = split(from - all3(start)), there = split(to - all3(start)), by = split(way);
    const End end = thin ? wall_met(at, there, by) : border_met(at, there, by);
    if (!any(end.mask)) return Met{};
    const Doubles part = of_path(end.part);
    const Doubles3 out = wall_normal(at.across + by.across * part, end.of_bore);
    const Doubles3 wall = out * select(end.outward, all_doubles(1.0), all_doubles(-1.0));
    const Doubles3 cap = all3(axis) * select((Longs)(by.height > 0.0), all_doubles(-1.0), all_doubles(1.0));
    return met(end.mask, part, select(end.of_cap, cap, wall), way);
  }

 private:
  struct AxialPoint {
    Doubles height;
    Doubles3 across;
  };
  struct PathInterval {
    Doubles from, to;
  };
  struct End {
    Longs mask;
    Doubles part;
    Longs of_cap, of_bore;
    Longs outward;  // the face that is met points away from the axis
  };

  MOTES_INLINE AxialPoint split(Doubles3 d) const {
    const Doubles height = dot(d, all3(axis));
    return {height, d - all3(axis) * height};
  }
  static MOTES_INLINE Doubles radius_at(Wall wall, const AxialPoint& at) { return wall.start + wall.slope * at.height; }
  static MOTES_INLINE Longs within(Wall wall, const AxialPoint& at) {
    const Doubles radius = radius_at(wall, at);
    return (Longs)(radius >= 0.0) & (Longs)(dot(at.across, at.across) <= radius * radius);
  }
  MOTES_INLINE Longs between_caps(Doubles height) const { return (Longs)(height >= 0.0) & (Longs)(height <= length); }
  MOTES_INLINE Longs contains(const AxialPoint& at) const {
    const Doubles least = radius_at(inner, at);
    const Longs solid = between_caps(at.height) & within(outer, at);
    return bored ? solid & (Longs)(dot(at.across, at.across) >= least * least) : solid;
  }

  /// Returns the part of a path within a wall: a s^2 + 2 b s + c <= 0. Where the path is steeper than a cone's side (a
  /// < 0), it is inside the cone beyond one root, and inside the cone's mirror image beyond the other.
  static MOTES_INLINE PathInterval stretch(Wall wall, const AxialPoint& at, const AxialPoint& by) {
    const Doubles radius = radius_at(wall, at), growth = wall.slope * by.height;
    const Doubles a = (dot(by.across, by.across) - growth * growth) + 0.0;  // never -0
    const Doubles b = dot(at.across, by.across) - radius * growth;
    const Doubles c = dot(at.across, at.across) - radius * radius;
    const Doubles square = b * b - a * c, root = sqrt(max(square, Doubles{}));
    // The roots are q / a and c / q: nothing cancels.
    const Doubles q = select((Longs)(b > 0.0), -(b + root), root - b);
    const Longs flat = (Longs)(q == 0.0);
    const Doubles one = q / select(flat, all_doubles(1.0), a), other = c / select(flat, all_doubles(1.0), q);
    const Doubles first = min(one, other), last = max(one, other);
    const Doubles never = all_doubles(kFar), always = all_doubles(-kFar);
    const Longs up = (Longs)(by.height > 0.0), steep = (Longs)(a < 0.0) & ~flat;
    const Longs met = (Longs)(square > 0.0) & ~flat, still = (Longs)(c <= 0.0);
    const PathInterval plain{select(met, first, select(still, always, never)),
                             select(met, last, select(still, never, always))};
    return {select(steep, select(up, last, always), plain.from), select(steep, select(up, never, first), plain.to)};
  }

  /// Returns the next border of the material, which is between caps and side without the bore: before the bore and
  /// behind it.
  MOTES_INLINE End border_met(const AxialPoint& at, const AxialPoint& there, const AxialPoint& by) const {
    const Longs inside = contains(at), differs = inside ^ contains(there);
    const Longs beyond = ((Longs)(at.height < 0.0) & (Longs)(there.height < 0.0)) |
                         ((Longs)(at.height > length) & (Longs)(there.height > length));
    const Longs solid = bored ? Longs{} : inside;  // convex
    if (!any(differs | ~(beyond | solid))) return End{};
    const Longs still = (Longs)(by.height == 0.0);
    const Doubles step = select(still, all_doubles(1.0), by.height);
    const Doubles to_start = -at.height / step, to_end = (length - at.height) / step;
    const Longs among = between_caps(at.height);
    const Doubles never = all_doubles(kFar), always = all_doubles(-kFar);
    const PathInterval caps{select(still, select(among, always, never), min(to_start, to_end)),
                            select(still, select(among, never, always), max(to_start, to_end))};
    const PathInterval side = stretch(outer, at, by);
    PathInterval bore{never, never};
    if (bored) {
      const PathInterval cut = stretch(inner, at, by);
      const Longs hollow = (Longs)(cut.from <= cut.to);
      bore = {select(hollow, cut.from, never), select(hollow, cut.to, never)};
    }
    const Doubles first = max(caps.from, side.from), last = min(caps.to, side.to);
    // Leaving the material: into the bore, if that is ahead.
    const Longs ahead = (Longs)(bore.from + bore.to > 0.0);
    const Doubles drops = select(ahead, bore.from, never), leaves = min(last, drops);
    const Longs falls = (Longs)(drops <= last);
    // Entering it: before the bore, unless that part is behind.
    const Doubles ends = min(last, bore.from), begins = max(first, bore.to);
    const Longs before = (Longs)(first <= ends) & (Longs)(first + ends > 0.0);
    const Longs behind = ~before & (Longs)(begins <= last) & (Longs)(begins + last > 0.0);
    const Doubles enters = select(before, first, begins);
    const Longs through = (before | behind) & (Longs)(enters >= 0.0) & (Longs)(enters <= 1.0);
    const Longs climbs = behind & (Longs)(bore.to >= first);

    const Longs of_bore = (inside & falls) | (~inside & climbs);
    const Longs of_cap = ~of_bore & select_longs(inside, (Longs)(caps.to < side.to), (Longs)(caps.from > side.from));
    const Longs hit = differs | (~inside & through) | (inside & falls & (Longs)(drops < 1.0));
    return {hit, select(inside, leaves, enters), of_cap, of_bore, of_bore ^ ~inside};
  }

  /// Returns where a path crosses a wall without thickness between the caps, inwards or outwards.
  MOTES_INLINE End wall_met(const AxialPoint& at, const AxialPoint& there, const AxialPoint& by) const {
    const Longs inside = within(outer, at), differs = inside ^ within(outer, there);
    if (!any(differs | ~inside)) return End{};
    const PathInterval side = stretch(outer, at, by);
    const auto on_wall = [&](Doubles part) __attribute__((always_inline)) {
      return between_caps(at.height + by.height * of_path(part));
    };
    const Longs crosses = (Longs)(side.from <= side.to) & (Longs)(side.from >= 0.0) & (Longs)(side.to <= 1.0);
    const Longs in = ~inside & (differs | crosses) & on_wall(side.from);
    const Longs out = ((inside & differs) | (~inside & ~differs & crosses & ~in)) & on_wall(side.to);
    return {in | out, select(in, side.from, side.to), Longs{}, Longs{}, in};
  }
  static MOTES_INLINE Longs select_longs(Longs mask, Longs yes, Longs no) { return (yes & mask) | (no & ~mask); }

  /// Returns the outward normal of a wall at offset `across` from the axis.
  MOTES_INLINE Doubles3 wall_normal(Doubles3 across, Longs of_bore) const {
    const Doubles slope = select(of_bore, all_doubles(inner.slope), all_doubles(outer.slope));
    return unit(unit(across) - all3(axis) * slope);
  }
};

}  // namespace motes::MOTES_ISA
