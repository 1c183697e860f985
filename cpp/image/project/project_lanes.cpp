// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/project/project_lanes.h"

#include "image/grid.h"
#include "image/project/screen_lanes.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

struct Projected {
  Mask visible;
  Uints position, depth, tile, flags;
};

// The tiles that a footprint touches along one axis: the first one, and 1 if it also touches the next one.
struct Span {
  Mask inside;
  Ints first, next;
};
// Adds without undefined behaviour: lanes that are not used may overflow.
MOTES_INLINE Ints plus(Ints a, int b) { return (Ints)((Uints)a + static_cast<std::uint32_t>(b)); }
MOTES_INLINE Span span(Ints start, int sub_bits, int footprint, int pixels) {
  const Ints first = start >> sub_bits;
  const Ints last = plus(first, footprint - 1);
  const Ints first_tile = max_ints(first, Ints{}) >> image::kTileBits;
  const Ints last_tile = min_ints(last, all_ints(pixels - 1)) >> image::kTileBits;
  const Mask inside = (Mask)((Uints)last < static_cast<std::uint32_t>(pixels + footprint - 1));
  return {inside, first_tile, last_tile - first_tile};
}

MOTES_INLINE Projected project_vector(const image::ProjectTask& t, std::size_t i) {
  const auto [across, upward, depth] = view_position(t.now, place_of(t, i));
  const Floats k = all(t.now.scale) / depth;
  const Floats screen_x = across * k;
  const Floats screen_y = -(upward * k);
  // Comparisons are false for NaN.
  const Mask sane = (depth >= all(t.near)) & (depth <= all(kLargest)) & (abs(screen_x) <= all(t.limit_x)) &
                    (abs(screen_y) <= all(t.limit_y));
  const Ints fixed_x = floor_where(sane, screen_x);
  const Ints fixed_y = floor_where(sane, screen_y);
  const int half = 1 << (t.sub_bits - 1);
  const Span over_x = span(plus(fixed_x, (t.width + 1 - t.footprint) * half), t.sub_bits, t.footprint, t.width);
  const Span over_y = span(plus(fixed_y, (t.height + 1 - t.footprint) * half), t.sub_bits, t.footprint, t.height);
  Projected p;
  p.visible = sane & over_x.inside & over_y.inside;
  p.position = ((Uints)fixed_x & 0xffffu) | ((Uints)fixed_y << 16);
  p.depth = (Uints)depth;
  p.tile = multiply_short((Uints)over_y.first, all_uints(static_cast<std::uint32_t>(t.columns))) + (Uints)over_x.first;
  p.flags = (Uints)over_x.next << 30 | (Uints)over_y.next << 31;
  return p;
}

void store_velocity(const image::ProjectTask& t, std::size_t i, const image::ProjectedBatch& out, std::size_t n,
                    const Selected& k) {
  for (std::size_t c = 0; c < 3; ++c) {
    store_selected(out.velocity + c * out.velocity_stride + n, k,
                   finite_bits(load_or(t.velocity[c], i, t.velocity_of_all[c])));
  }
}

template <bool kOneColor, bool kDepth>
image::ProjectedCount project(const image::ProjectTask& task, std::size_t first, std::size_t last,
                              const image::ProjectedBatch& batch) {
  const image::ProjectTask t = task;  // copies whose members the stores below cannot change
  const image::ProjectedBatch out = batch;
  if (kOneColor) {
    const Uints color = color_vector(t, 0);
    if (!any(gives_light(color, t.dark))) return {};
    out.color[0] = color[0];
  }
  Ahead ahead(t);
  if (kDepth && out.velocity != nullptr) ahead.add(t.velocity);
  std::size_t n = 0, several = 0;
  for (std::size_t i = first; i < last; i += kLanes) {
    ahead.fetch(i);
    Projected p = project_vector(t, i);
    if (last - i < kLanes) p.visible &= first_lanes(last - i);
    const Uints color = kOneColor ? Uints{} : color_vector(t, i);
    if (!kOneColor) p.visible &= gives_light(color, t.dark);
    const Selected k(p.visible);
    if (k.number() == 0) continue;
    store_selected(out.position + n, k, p.position);
    if (!kOneColor) store_selected(out.color + n, k, color);
    store_selected(out.tile + n, k, p.tile);
    if (kDepth) store_selected(out.depth + n, k, p.depth);
    if (kDepth && out.velocity != nullptr) store_velocity(t, i, out, n, k);
    several += list_several(out.several + several, n, p.flags, p.visible, k);
    n += k.number();
  }
  return {n, several};
}

image::ProjectedCount project_any(const image::ProjectTask& t, std::size_t first, std::size_t last,
                                  const image::ProjectedBatch& out) {
  if (t.one_color()) {
    return out.depth != nullptr ? project<true, true>(t, first, last, out) : project<true, false>(t, first, last, out);
  }
  return out.depth != nullptr ? project<false, true>(t, first, last, out) : project<false, false>(t, first, last, out);
}

}  // namespace

extern const image::ProjectLanes project_lanes = {project_any};

}  // namespace motes::MOTES_ISA
