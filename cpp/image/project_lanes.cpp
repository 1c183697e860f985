// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/project_lanes.h"

#include "image/grid.h"
#include "image/screen_lanes.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

struct Projected {
  Mask visible;
  Uints position, depth, tile;
};

// The tiles that a footprint starting at fixed-point `start` touches along one axis.
struct Span {
  Mask inside, two;
  Ints first;
};
MOTES_INLINE Span span(Ints start, int sub_bits, int footprint, int pixels) {
  const Ints first = start >> sub_bits;
  const Ints last = first + (footprint - 1);
  const Ints first_tile = max_ints(first, Ints{}) >> image::kTileBits;
  const Ints last_tile = min_ints(last, all_ints(pixels - 1)) >> image::kTileBits;
  return {(last >= 0) & (first < pixels), first_tile != last_tile, first_tile};
}

MOTES_INLINE Projected project_vector(const image::ProjectTask& t, std::size_t i) {
  const auto [across, upward, depth] = sight(t.now, place_of(t, i));
  const Floats k = all(t.now.scale) / depth;
  const Floats screen_x = across * k;
  const Floats screen_y = -(upward * k);
  // Comparisons are false for NaN, so only finite values reach the conversion to integers.
  const Mask sane = (depth >= all(t.near)) & (depth <= all(kLargest)) & (abs(screen_x) <= all(t.limit_x)) &
                    (abs(screen_y) <= all(t.limit_y));
  const Ints fixed_x = floor_to_ints(select(sane, screen_x, Floats{}));
  const Ints fixed_y = floor_to_ints(select(sane, screen_y, Floats{}));
  const int half = 1 << (t.sub_bits - 1);
  const Span over_x = span(fixed_x + (t.width + 1 - t.footprint) * half, t.sub_bits, t.footprint, t.width);
  const Span over_y = span(fixed_y + (t.height + 1 - t.footprint) * half, t.sub_bits, t.footprint, t.height);
  Projected p;
  p.visible = sane & over_x.inside & over_y.inside;
  p.position = ((Uints)fixed_x & 0xffffu) | ((Uints)fixed_y << 16);
  p.depth = (Uints)depth;
  p.tile = (Uints)(over_y.first * t.columns + over_x.first) | ((Uints)over_x.two & image::kNextColumn) |
           ((Uints)over_y.two & image::kNextRow);
  return p;
}

void store_velocity(const image::ProjectTask& t, std::size_t i, const image::ProjectedBatch& out, std::size_t n,
                    const Selected& k) {
  for (std::size_t c = 0; c < 3; ++c) {
    store_selected(out.velocity + c * out.velocity_stride + n, k,
                   finite_bits(load_or(t.velocity[c], i, t.velocity_of_all[c])));
  }
}

// Lists which of the visible particles n .. n + number - 1 touch several tiles: no more than there are lanes, whose
// tiles have been stored.
MOTES_INLINE std::size_t list_several(std::uint32_t* to, const std::uint32_t* tiles, std::size_t n,
                                      std::size_t number) {
#if MOTES_WIDTH >= 256
  const Mask touches = (Mask)((load_uints(tiles + n) & ~image::kTileNumber) != 0u) & lanes_below(number);
  return squeeze(to, lane_numbers() + static_cast<std::uint32_t>(n), touches);
#else
  std::size_t count = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    to[count] = static_cast<std::uint32_t>(n + lane);
    count += static_cast<std::size_t>(lane < number) & static_cast<std::size_t>(tiles[n + lane] > image::kTileNumber);
  }
  return count;
#endif
}

template <bool kOneColor, bool kDepth>
image::ProjectedCount project(const image::ProjectTask& task, std::size_t first, std::size_t last,
                              const image::ProjectedBatch& out) {
  const image::ProjectTask t = task;  // a copy whose members the stores below cannot change
  const Uints color_of_all = color_vector(t, 0);
  std::size_t n = 0, several = 0;
  for (std::size_t i = first; i < last; i += kLanes) {
    const Projected p = project_vector(t, i);
    Mask visible = p.visible;
    if (last - i < kLanes) visible &= lanes_below(last - i);
    const Uints color = kOneColor ? color_of_all : color_vector(t, i);
    visible &= gives_light(color, t.dark);
    if (!any(visible)) continue;
    const Selected k(visible);
    kOneColor ? store_selected_with(out.head + 2 * n, k, p.position, color)
              : store_selected(out.head + 2 * n, k, p.position, color);
    store_selected(out.tile + n, k, p.tile);
    if (kDepth) store_selected(out.depth + n, k, p.depth);
    if (kDepth && out.velocity != nullptr) store_velocity(t, i, out, n, k);
    several += list_several(out.several + several, out.tile, n, k.number());
    n += k.number();
  }
  return {n, several};
}

image::ProjectedCount project_any(const image::ProjectTask& t, std::size_t first, std::size_t last,
                                  const image::ProjectedBatch& out) {
  if (one_color(t)) {
    return out.depth != nullptr ? project<true, true>(t, first, last, out) : project<true, false>(t, first, last, out);
  }
  return out.depth != nullptr ? project<false, true>(t, first, last, out) : project<false, false>(t, first, last, out);
}

}  // namespace

extern const image::ProjectLanes project_lanes = {project_any};

}  // namespace motes::MOTES_ISA
