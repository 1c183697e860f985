// The light that particles let through to given positions. Compiled once for each instruction set.
#pragma once

#include "image/light/shadow_grid.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

/// Positions in a grid's lattice, in cells of the finest box; `known`: the light's rays reach them.
struct InLattice {
  Floats column, row, layer;
  Mask known;
  Floats width;  // of a column of the finest box there, m
};

MOTES_INLINE InLattice in_lattice(const image::ShadowSpace& space, Floats3 place) {
  const Floats3 offset = place - all3(space.origin);
  Floats across = dot(offset, all3(space.right)), upward = dot(offset, all3(space.up));
  const Floats ahead = dot(offset, all3(space.ahead));
  Floats width = all(1.0f / space.cells[0]);
  Mask known = finite(offset);
  if (space.point) {
    known &= ahead > 1e-6f;
    const Floats distance = select(known, ahead, all(1.0f)), inverse = 1.0f / distance;
    across *= inverse;
    upward *= inverse;
    width *= distance;
  }
  return {only(known, across) * space.cells[0], only(known, upward) * space.cells[0],
          only(known, ahead) * space.cells[1], known, width};
}

/// Positions in boxes, in cells from each box's corner.
struct InBox {
  Floats column, row, layer;
  Floats cell;  // width of a cell, in cells of the finest box
  Ints box;
  Mask known;
};

/// Returns positions in the finest box, of those with `fits(box, column, row, layer)`.
template <class Fits>
MOTES_INLINE InBox finest_box(const image::ShadowSpace& space, const InLattice& at, const Fits& fits) {
  const auto in_box = [&](int box) __attribute__((always_inline)) {
    const float part = 1.0f / static_cast<float>(1 << box);
    const float* const first = space.first[box];
    InBox in{at.column * part - first[0],
             at.row * part - first[1],
             at.layer * part - first[2],
             all(static_cast<float>(1 << box)),
             all_ints(box),
             at.known};
    in.known &= fits(box, in.column, in.row, in.layer);
    return in;
  };
  InBox found = in_box(0);
  if (!any(at.known & ~found.known)) return found;
  for (int box = 1; box < image::kShadowBoxes; ++box) {
    const Mask open = ~found.known;
    const InBox in = in_box(box);
    found = {select(open, in.column, found.column), select(open, in.row, found.row),
             select(open, in.layer, found.layer),   select(open, in.cell, found.cell),
             select(open, in.box, found.box),       found.known | in.known};
  }
  return found;
}

/// Particles of at most this width, in cells, are spread over the eight cells around them; wider ones cover cells as
/// discs do, in boxes where they are at most kMostWide cells wide.
inline constexpr float kFewCells = 1.1f, kMostWide = 8;

/// Returns the boxes to which particles add: the finest that contain them and are coarse enough. `width`: of the
/// particles, in cells of the finest box.
MOTES_INLINE InBox box_of_caster(const image::ShadowSpace& space, const InLattice& at, Floats width) {
  return finest_box(space, at, [&](int box, Floats column, Floats row, Floats layer) __attribute__((always_inline)) {
    constexpr float kColumns = image::kShadowColumns, kLayers = image::kShadowLayers;
    const Floats wide = width * (1.0f / static_cast<float>(1 << box));
    const Mask inside = (layer >= 0.5f) & (layer <= kLayers - 0.5f);
    if (box + 1 == image::kShadowBoxes) {
      return inside & (column >= 0.0f) & (column <= kColumns) & (row >= 0.0f) & (row <= kColumns);
    }
    const Floats margin = wide * 0.5f + 0.5f, far = kColumns - margin;
    return inside & (wide <= kMostWide) & (column >= margin) & (column <= far) & (row >= margin) & (row <= far);
  });
}

/// Returns how far towards the light the particle's own shadow begins, in layers of the finest box. A particle must not
/// shade itself: it adds to the two layers around it.
MOTES_INLINE Floats own_shadow(const image::ShadowSpace& space, Floats3 place, Floats diameter) {
  const InLattice at = in_lattice(space, place);
  const InBox box = box_of_caster(space, at, diameter / at.width);
  return box.cell * 1.5f;
}

/// Returns the part of a light that arrives at positions. `back`: how many layers of the finest box they are moved
/// towards the light.
MOTES_INLINE Floats light_through(const image::ShadowMap& map, Floats3 place, Floats back) {
  InLattice lattice = in_lattice(map.space, place);
  lattice.layer -= back;
  constexpr int kColumns = image::kShadowColumns, kPlane = kColumns * kColumns;
  constexpr float kLast = kColumns - 1.001f, kDeepest = image::kShadowLayers - 0.001f;
  const InBox at = finest_box(
      map.space, lattice, [&](int box, Floats column, Floats row, Floats layer) __attribute__((always_inline)) {
        // The coarsest box's last plane holds all the shadows behind it.
        const bool coarsest = box + 1 == image::kShadowBoxes;
        const Mask above = (column >= 0.5f) & (column <= kColumns - 0.5f) & (row >= 0.5f) & (row <= kColumns - 0.5f);
        return above & (layer >= 0.0f) & (layer <= (coarsest ? __FLT_MAX__ : float{image::kShadowLayers}));
      });
  if (!any(at.known)) return all(1.0f);
  const Floats column = min(max(only(at.known, at.column) - 0.5f, all(0.0f)), all(kLast));
  const Floats row = min(max(only(at.known, at.row) - 0.5f, all(0.0f)), all(kLast));
  const Floats layer = min(max(only(at.known, at.layer), all(0.0f)), all(kDeepest));
  const Ints i = to_ints(column), j = to_ints(row), k = to_ints(layer);
  const Floats right = column - to_floats(i), below = row - to_floats(j), beyond = layer - to_floats(k);
  const Ints box = at.box & at.known;
  const Ints first = ((box * (image::kShadowLayers + 1) + k) * kColumns + j) * kColumns + i;
  const auto plane = [&](Ints start) __attribute__((always_inline)) {
    const Floats a = gather(map.left, start), b = gather(map.left, start + 1);
    const Floats c = gather(map.left, start + kColumns), d = gather(map.left, start + (kColumns + 1));
    const Floats above = a + (b - a) * right, under = c + (d - c) * right;
    return above + (under - above) * below;
  };
  const Floats near = plane(first), far = plane(first + kPlane);
  return select(at.known, near + (far - near) * beyond, all(1.0f));
}

}  // namespace motes::MOTES_ISA
