// A ball, or a thick shell if the inner radius is above 0.
#pragma once

#include "shapes/lanes.h"

namespace motes::MOTES_ISA {

struct ExactBall;  // in exact_solid.h

struct SphereLanes {
  static constexpr bool kDrawsTogether = true;
  using Exact = ExactBall;
  const shapes::Shape* shape;
  Float3 center;
  float radius, inner;

  static MOTES_INLINE SphereLanes from(const shapes::Shape& s) {
    const auto sphere = s.as<shapes::numbers::sphere>();
    return {&s, of(sphere.center), sphere.radius, sphere.inner_radius};
  }
  MOTES_INLINE Mask contains(Floats3 p) const {
    const Floats3 d = p - all3(center);
    const Floats distance2 = dot(d, d);
    const float outer2 = radius * radius, inner2 = inner * inner;
    const Mask sure = far_from(distance2, outer2) & (inner > 0.0f ? far_from(distance2, inner2) : ~Mask{});
    if (any(~sure)) return contains_exactly(*shape, p);
    return (distance2 <= outer2) & (distance2 >= inner2);
  }

  MOTES_INLINE Floats3 sample(Draws& draws) const {
    const Uints4 bits = draws.bits();
    // A random direction after Archimedes: the height on a sphere is uniform.
    const Floats z = 1.0f - 2.0f * unit(bits.a);
    Floats cosine, sine;
    cos_sin_turn(unit(bits.b), cosine, sine);
    const Floats across = sqrt(max(1.0f - z * z, Floats{}));
    // Uniform by volume: the cubed distance is uniform.
    const float inner3 = inner * inner * inner;
    const Floats r = cube_root(all(inner3) + unit(bits.c) * (radius * radius * radius - inner3));
    return all3(center) + Floats3{across * cosine, across * sine, z} * r;
  }

  /// Returns false where a path stays clear of the outer surface.
  MOTES_INLINE Mask may_meet(Floats3 p, Floats3 to) const {
    const Floats3 d = p - all3(center), e = to - all3(center), way = to - p;
    const Floats d2 = dot(d, d), e2 = dot(e, e);
    const float low = radius * radius * (1.0f - kRounding), high = radius * radius * (1.0f + kRounding);
    const Mask inside = (d2 < low) & (e2 < low), outside = (d2 > high) & (e2 > high);
    // The path is nearest to the centre at one of its ends, or stays too far from it.
    const Floats a = dot(way, way), b = dot(d, way);
    // In units of the radius, as the fourth power of a metre's fractions may be too small for a float.
    const float unit2 = 1.0f / (power_of_two(radius) * power_of_two(radius));
    const Floats far2 = d2 * unit2;
    const Mask past =
        (b >= 0.0f) | (a + b <= 0.0f) | (far2 * a - b * (b * unit2) > a * (high * unit2 + far2 * (2.0f * kRounding)));
    return ~(inside | (outside & past));
  }

  /// Returns where a path from outside enters the outer surface, or one from inside leaves it.
  MOTES_INLINE Hit hit(Floats3 p, Floats3 path) const {
    const float unit = 1.0f / power_of_two(radius);  // fourth powers of lengths would be too small
    const float own = radius * unit;
    const Floats3 d = (p - all3(center)) * unit;
    path = path * unit;
    const Floats a = dot(path, path);
    const Floats b = dot(d, path);
    const Floats c = dot(d, d) - own * own;
    const Mask inside = c < 0.0f;
    const Floats discriminant = b * b - a * c;
    const Floats root = sqrt(max(discriminant, Floats{}));
    const Floats part = select(inside, root - b, -root - b) / select(a > 0.0f, a, all(1.0f));
    const Mask toward = inside | (b < 0.0f);
    const Mask mask = toward & (a > 0.0f) & (discriminant > 0.0f) & (part <= 1.0f) & (part >= 0.0f);
    const Floats3 out = (d + path * part) * (1.0f / own);
    return {mask, select(mask, part, Floats{}), out * select(inside, all(-1.0f), all(1.0f))};
  }

 private:
  static MOTES_INLINE Mask far_from(Floats distance2, float radius2) {
    return (distance2 < radius2 * (1.0f - kRounding)) | (distance2 > radius2 * (1.0f + kRounding));
  }
};

}  // namespace motes::MOTES_ISA
