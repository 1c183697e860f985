// Compiled once for each instruction set: the code of the rare shapes, of unions of any shapes, and of exact tests.
#include "shapes/exact_flat.h"
#include "shapes/exact_shell.h"
#include "shapes/exact_solid.h"
#include "shapes/visit.h"

namespace motes::MOTES_ISA {
namespace {

// visit() sends only the rare kinds here.
template <class Use>
MOTES_INLINE auto use_rare(const RareLanes& rare, const Use& use) {
  switch (rare.kind) {
#define MOTES_SHAPE(kind, ...) \
  case shapes::Kind::kind: break;
#define MOTES_RARE_SHAPE(kind, ...) \
  case shapes::Kind::kind: return use(rare.kind##_lanes);
#include "shapes/list.inc"
  }
  __builtin_unreachable();
}

// Not inlined: one copy for all shapes with this exact test.
template <class Exact>
__attribute__((noinline)) Met meet_exactly(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to) {
  return Exact::of(shape).meet(from, to);
}
template <class Exact>
__attribute__((noinline)) Mask holds_exactly(const shapes::Shape& shape, const Floats3& p) {
  if constexpr (requires(const Exact& exact, const Doubles3& q) { exact.contains(q); }) {
    const Exact exact = Exact::of(shape);
    return join(exact.contains(low_half(p)), exact.contains(high_half(p)));
  }
  return Mask{};
}

template <class Lanes>
MOTES_INLINE Met meet_one(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to) {
  if constexpr (requires { typename Lanes::Exact; }) return meet_exactly<typename Lanes::Exact>(shape, from, to);
  return Met{};
}
template <class Lanes>
MOTES_INLINE Mask contains_one(const shapes::Shape& shape, const Floats3& p) {
  if constexpr (requires { typename Lanes::Exact; }) return holds_exactly<typename Lanes::Exact>(shape, p);
  return Mask{};
}

__attribute__((noinline)) Mask may_meet_one(const shapes::Shape& shape, const Floats3& p, const Floats3& to) {
  Mask near = Mask{};
  visit(shape, [&](const auto& lanes) __attribute__((always_inline)) {
    if constexpr (requires { lanes.may_meet(p, to); }) near = lanes.may_meet(p, to);
  });
  return near;
}

/// Finds where paths meet a mesh. The side of a place is the sign of the mesh's distance in single precision.
__attribute__((noinline)) Met meet_mesh(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to) {
  const Floats3 p = join(from, from), q = join(to, to);
  const Hit hit = MeshLanes::from(shape).meet(p, q);
  return {low_half(hit.mask), low_half(hit.part), low_half(hit.normal)};
}

__attribute__((noinline)) Met meet_union(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to) {
  Met nearest{};
  const Floats3 p = join(from, from), q = join(to, to);
  for (int i = 0; i < shape.parts; ++i) {
    if (!any(may_meet_one(shape.part[i], p, q))) continue;
    const Met met = meet(shape.part[i], from, to);
    const Longs nearer = met.mask & (~nearest.mask | (Longs)(met.part < nearest.part));
    nearest = {nearest.mask | met.mask, select(nearer, met.part, nearest.part),
               select(nearer, met.normal, nearest.normal)};
  }
  return nearest;
}

}  // namespace

Met meet(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to) {
  if (shape.kind == shapes::Kind::united) return meet_union(shape, from, to);
  if (shape.kind == shapes::Kind::mesh) return meet_mesh(shape, from, to);
  switch (shape.kind) {
#define MOTES_SHAPE(kind, Name, ...) \
  case shapes::Kind::kind: return meet_one<Name##Lanes>(shape, from, to);
#include "shapes/list.inc"
  }
  __builtin_unreachable();
}

Met meet_by_ends(const shapes::Shape& shape, const Doubles3& from, const Doubles3& to) {
  if (shape.kind == shapes::Kind::plane) return ExactPlane::of(shape).meet_both(from, to);
  Met met = meet(shape, from, to);
  if (shape.kind == shapes::Kind::sphere) met.mask &= ExactBall::of(shape).parts(from, to);
  return met;
}

Mask contains_exactly(const shapes::Shape& shape, const Floats3& p) {
  switch (shape.kind) {
#define MOTES_SHAPE(kind, Name, ...) \
  case shapes::Kind::kind: return contains_one<Name##Lanes>(shape, p);
#include "shapes/list.inc"
  }
  __builtin_unreachable();
}

RareLanes RareLanes::from(const shapes::Shape& shape) {
  RareLanes rare;
  rare.kind = shape.kind;
  switch (shape.kind) {
#define MOTES_SHAPE(kind, ...) \
  case shapes::Kind::kind: break;
#define MOTES_RARE_SHAPE(kind, Name, ...) \
  case shapes::Kind::kind: rare.kind##_lanes = Name##Lanes::from(shape); break;
#include "shapes/list.inc"
  }
  return rare;
}

Mask RareLanes::contains(const Floats3& p) const {
  return use_rare(*this, [&](const auto& lanes) __attribute__((always_inline)) { return lanes.contains(p); });
}

Mask RareLanes::may_meet(const Floats3& p, const Floats3& to) const {
  return use_rare(*this, [&](const auto& lanes) __attribute__((always_inline)) {
    if constexpr (requires { lanes.may_meet(p, to); }) return lanes.may_meet(p, to);
    return Mask{};
  });
}

Floats3 RareLanes::sample(Draws& draws) const {
  return use_rare(*this, [&](const auto& lanes) __attribute__((always_inline)) { return lanes.sample(draws); });
}

Hit RareLanes::hit(const Floats3& p, const Floats3& path) const {
  return use_rare(*this, [&](const auto& lanes) __attribute__((always_inline)) { return lanes.hit(p, path); });
}

Mask UnionLanes::contains(const Floats3& p) const {
  Mask inside = Mask{};
  for (int i = 0; i < parts; ++i) {
    visit(part[i], [&](const auto& lanes) __attribute__((always_inline)) { inside |= lanes.contains(p); });
  }
  return inside;
}

Mask UnionLanes::may_meet(const Floats3& p, const Floats3& to) const {
  Mask near = Mask{};
  for (int i = 0; i < parts; ++i) near |= may_meet_one(part[i], p, to);
  return near;
}

Floats3 UnionLanes::sample(Draws& draws) const {
  const Floats choice = unit(draws.bits().a);
  Floats3 point{};
  float from = 0.0f;
  for (int i = 0; i < parts; ++i) {
    const Mask chosen = (choice >= from) & (choice < part[i].upto);
    from = part[i].upto;
    if (!any(chosen)) continue;
    Draws same = draws;  // every part starts at the same draw: a lane's result does not depend on its neighbours
    visit(part[i],
          [&](const auto& lanes) __attribute__((always_inline)) { point = select(chosen, lanes.sample(same), point); });
  }
  draws.draw += 1;  // no shape uses more
  return point;
}

Hit UnionLanes::hit(const Floats3& p, const Floats3& path) const {
  Hit nearest = no_hit();
  for (int i = 0; i < parts; ++i) {
    visit(part[i], [&](const auto& lanes) __attribute__((always_inline)) {
      const Hit hit = lanes.hit(p, path);
      const Mask nearer = hit.mask & (~nearest.mask | (hit.part < nearest.part));
      nearest = {nearest.mask | hit.mask, select(nearer, hit.part, nearest.part),
                 select(nearer, hit.normal, nearest.normal)};
    });
  }
  return nearest;
}

}  // namespace motes::MOTES_ISA
