// Compiled once for each instruction set: the code of the rare shapes, and of unions of any shapes.
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

}  // namespace

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
  draws.draw += 1;  // no shape takes more
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
