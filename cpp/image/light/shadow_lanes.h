// The light that particles let through to given positions. Compiled once for each instruction set.
#pragma once

#include "image/light/shadow_grid.h"
#include "simd/elementary.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// Positions in a grid, in cells from its corner; `known`: the grid contains the light's rays to them.
struct InGrid {
  Floats column, row, layer;
  Mask known;
  Floats width;  // of a column there, m
};

MOTES_INLINE InGrid in_grid(const image::ShadowSpace& space, Floats3 place) {
  const Floats3 offset = place - all3(space.origin);
  Floats across = dot(offset, all3(space.right)), upward = dot(offset, all3(space.up));
  const Floats ahead = dot(offset, all3(space.ahead));
  Floats width = all(1.0f / space.cells[0]);
  Mask known = ~Mask{};
  if (space.point) {
    known = ahead > 1e-6f;
    const Floats inverse = 1.0f / select(known, ahead, all(1.0f));
    across *= inverse;
    upward *= inverse;
    width *= ahead;
  }
  const Floats column = (across - space.first[0]) * space.cells[0], row = (upward - space.first[1]) * space.cells[0];
  constexpr float kMost = image::kShadowColumns;
  known &= (column >= 0.0f) & (column <= kMost) & (row >= 0.0f) & (row <= kMost);
  return {column, row, (ahead - space.first[2]) * space.cells[1], known, width};
}

/// Returns the part of a light that arrives at positions. `back`: how many layers they are moved towards the light.
MOTES_INLINE Floats light_through(const image::ShadowMap& map, Floats3 place, Floats back) {
  const InGrid at = in_grid(map.space, place);
  if (!any(at.known)) return all(1.0f);
  constexpr int kColumns = image::kShadowColumns, kPlane = kColumns * kColumns;
  constexpr float kLast = kColumns - 1.001f, kDeepest = image::kShadowLayers - 0.001f;
  const Floats column = min(max(only(at.known, at.column) - 0.5f, all(0.0f)), all(kLast));
  const Floats row = min(max(only(at.known, at.row) - 0.5f, all(0.0f)), all(kLast));
  const Floats layer = min(max(only(at.known, at.layer - back), all(0.0f)), all(kDeepest));
  const Ints i = to_ints(column), j = to_ints(row), k = to_ints(layer);
  const Floats right = column - to_floats(i), below = row - to_floats(j), beyond = layer - to_floats(k);
  const Ints first = (k * kColumns + j) * kColumns + i;
  const auto plane = [&](Ints start) __attribute__((always_inline)) {
    const Floats a = gather(map.depths, start), b = gather(map.depths, start + 1);
    const Floats c = gather(map.depths, start + kColumns), d = gather(map.depths, start + (kColumns + 1));
    const Floats above = a + (b - a) * right, under = c + (d - c) * right;
    return above + (under - above) * below;
  };
  const Floats near = plane(first), far = plane(first + kPlane);
  const Floats depth = min(near + (far - near) * beyond, all(80.0f));
  return select(at.known, exp(-depth), all(1.0f));
}

}  // namespace motes::MOTES_ISA
