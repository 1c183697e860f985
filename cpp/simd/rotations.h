// Rotations in space as unit quaternions, one per lane.
#pragma once

#include "simd/elementary.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// x, y, z: the axis times the sine of half the angle; w: the cosine of half the angle.
struct Rotations {
  Floats x, y, z, w;
};

/// Scales quaternions to length 1. Those that are 0 or beyond float32's range become the identity.
MOTES_INLINE Rotations unit(Rotations q) {
  const Floats most = max(max(abs(q.x), abs(q.y)), max(abs(q.z), abs(q.w)));
  // NOLINTNEXTLINE(misc-redundant-expression): NaN differs from itself
  const Mask usable = (most > 1e-30f) & (most < 1e30f) & (q.x == q.x) & (q.y == q.y) & (q.z == q.z) & (q.w == q.w);
  const Floats scale = 1.0f / select(usable, most, all(1.0f));  // the squares below neither vanish nor overflow
  const Rotations s = {only(usable, q.x * scale), only(usable, q.y * scale), only(usable, q.z * scale),
                       select(usable, q.w * scale, all(1.0f))};
  const Floats part = 1.0f / sqrt(s.x * s.x + s.y * s.y + s.z * s.z + s.w * s.w);
  return {s.x * part, s.y * part, s.z * part, s.w * part};
}

/// Returns the rotation `b` followed by `a`.
MOTES_INLINE Rotations operator*(Rotations a, Rotations b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

MOTES_INLINE Rotations select(Mask mask, Rotations yes, Rotations no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z), select(mask, yes.w, no.w)};
}

/// Return the axes of space as rotated by a unit quaternion: the columns of its matrix.
MOTES_INLINE Floats3 turned_x(Rotations q) {
  return {1.0f - 2.0f * (q.y * q.y + q.z * q.z), 2.0f * (q.x * q.y + q.z * q.w), 2.0f * (q.x * q.z - q.y * q.w)};
}
MOTES_INLINE Floats3 turned_y(Rotations q) {
  return {2.0f * (q.x * q.y - q.z * q.w), 1.0f - 2.0f * (q.x * q.x + q.z * q.z), 2.0f * (q.y * q.z + q.x * q.w)};
}
MOTES_INLINE Floats3 turned_z(Rotations q) {
  return {2.0f * (q.x * q.z + q.y * q.w), 2.0f * (q.y * q.z - q.x * q.w), 1.0f - 2.0f * (q.x * q.x + q.y * q.y)};
}

/// Returns the rotation about an axis. `way`: the unit axis times the angle, radians.
MOTES_INLINE Rotations rotation_by(Floats3 way) {
  const Floats angle = sqrt(dot(way, way));
  Floats cosine, sine;
  cos_sin(angle * 0.5f, cosine, sine);
  const Floats part = select(angle > 1e-6f, sine / angle, all(0.5f));
  return {way.x * part, way.y * part, way.z * part, cosine};
}

/// Returns the shortest rotation that takes one unit vector to another. If they are opposite, it is half a turn about
/// `side`, a unit vector perpendicular to `from`.
MOTES_INLINE Rotations shortest(Floats3 from, Floats3 to, Floats3 side) {
  const Floats3 axis = cross(from, to);
  const Floats along = dot(from, to);
  const Mask opposite = along < -0.999999f;
  return unit(
      select(opposite, Rotations{side.x, side.y, side.z, Floats{}}, Rotations{axis.x, axis.y, axis.z, 1.0f + along}));
}

}  // namespace motes::MOTES_ISA
