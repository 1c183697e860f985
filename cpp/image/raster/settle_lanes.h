// Hides records whose centre is close behind a surface: see Behind. Nothing has branches that depend on one record,
// because depths of successive records are unrelated.
#pragma once

#include "image/raster/pixel_lanes.h"
#include "image/raster/point_lanes.h"
#include "image/raster/splat_lanes.h"
#include "simd/floats3.h"
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {

// Relative uncertainty of depths, from single precision and the picture's grid.
inline constexpr float kLeastMargin = 1.0f / 4096;
// Greatest ratio between a surface's depth under the edge of a particle's disc, which may be beyond the horizon, and
// that at its centre.
inline constexpr float kHorizon = 4096;

// Centres of records in units of positions from the image's middle, their radii in px, and their depths.
struct Centers {
  Ints x, y;
  Floats radius, depth;
};

MOTES_INLINE Centers fixed_centers(const image::Settling& s, Uints positions, Uints depths) {
  return {(Ints)(positions << 16) >> 16, (Ints)positions >> 16, all(s.radius), (Floats)depths};
}

// The pixels nearest to centres, and where the centres are relative to their middles, px.
struct NearestPixels {
  Ints column, row;
  Floats right, down;
};

MOTES_INLINE NearestPixels nearest_pixels(const image::Settling& s, const Centers& c) {
  const Ints right = c.x + c.x + s.first_column, down = c.y + c.y + s.first_row, zero{};
  const Ints column = min_ints(max_ints(right >> s.shift, zero), all_ints(s.last_column));
  const Ints row = min_ints(max_ints(down >> s.shift, zero), all_ints(s.last_row));
  const float unit = 1.0f / static_cast<float>(1 << s.shift);
  const auto away = [&](Ints at, Ints pixel) { return to_floats(at) * unit - (to_floats(pixel) + 0.5f); };
  return {column, row, away(right, column), away(down, row)};
}

MOTES_INLINE Ints block_of(const NearestPixels& at) {
  return 4 * ((at.row >> image::kBlockBits) * image::kBlocks + (at.column >> image::kBlockBits));
}

// Returns which depths are those of the block's surfaces, roughly.
MOTES_INLINE Mask in_block(const image::Settling& s, const NearestPixels& at, const Centers& c) {
  const Pair depths = gather_pairs(&s.blocks->low, block_of(at));
  const Mask often = c.radius <= s.often_radius;
  const Floats low = select(often, depths.first, all(s.low)), most = select(often, depths.second, all(s.high));
  return (c.depth >= low) & (c.depth <= (s.flat ? most : all(__builtin_inff())));
}

MOTES_INLINE Floats gathered(const std::uint32_t* from, Ints at) {
  return gather(reinterpret_cast<const float*>(from), at);
}

// Returns the depths from which on surfaces hide particles.
MOTES_INLINE Floats hiding(const image::Settling& s, const NearestPixels& at) {
  return gathered(s.hides, at.row * image::kTile + at.column);
}

// Returns which centres may be so close behind the surface at their pixel that something of them would show, according
// to the depth `hides` from which on it hides particles.
MOTES_INLINE Mask is_close(const image::Settling& s, const NearestPixels& at, const Centers& c, Floats hides) {
  const Pair block = gather_pairs(&s.blocks->bias, block_of(at));
  const Floats bias = block.first, slope = block.second, reach = c.radius + 1.0f;
  const Ints word = (Ints)gathered(s.steep, at.row * 2 + (at.column >> 5));
  const Mask steep = ((word >> (at.column & 31)) & 1) != 0;
  const Floats away = max(abs(at.right), abs(at.down)), left = 1.0f - slope * (away + reach);
  const Mask in_front = c.depth * (slope * away + 1.0f) < (hides - bias) * 0.9999f;
  const Mask beyond = (left > 0.25f) & (c.depth * left > hides * (reach * s.pixel + 1.0f) * 1.0001f);
  return (hides < all(__builtin_inff())) & (steep | ~(in_front | beyond));
}

// Returns how much normals of neighbouring pixels on the same object differ from this pixel's: 0 on flat surfaces. Only
// for the `chosen` lanes.
MOTES_OUTLINE Floats bend(const image::Settling& s, Ints column, Ints row, const Floats3& normal, Mask chosen) {
  const auto index = [&](Ints x, Ints y) { return (y * image::kSurfaceStride + x) & chosen; };
  const auto object = [&](Ints at) { return ((Ints)gather(s.surfaces + 4 * s.plane, at) - 1) >> 2; };
  const Ints own = object(index(column, row)), zero{};
  Floats most{};
  for (int side = 0; side < 4; ++side) {
    const int across = side < 2 ? 2 * side - 1 : 0, below = side < 2 ? 0 : 2 * side - 5;
    const Ints x = min_ints(max_ints(column + across, zero), all_ints(s.last_column));
    const Ints y = min_ints(max_ints(row + below, zero), all_ints(s.last_row));
    const Ints at = index(x, y);
    const auto change = [&](int axis, Floats of) { return abs(gather(s.surfaces + axis * s.plane, at) - of); };
    const Floats sum = change(1, normal.x) + change(2, normal.y) + change(3, normal.z);
    most = select(object(at) == own, max(most, sum), most);
  }
  return most;
}

// Returns depths at which the surfaces at the nearest pixels hide those of the `close` records whose centres are behind
// them; other depths do not change. A surface is replaced by its tangent plane, whose inverse depth is linear in the
// image.
MOTES_INLINE Floats settled(const image::Settling& s, const NearestPixels& at, const Centers& c, Floats hides,
                            Mask close) {
  const Ints index = (at.row * image::kSurfaceStride + at.column) & close;
  const auto plane = [&](int number) { return gather(s.surfaces + number * s.plane, index); };
  const Floats surface = plane(0);
  const Floats3 normal{plane(1), plane(2), plane(3)};
  const auto towards = [&](const float* way) { return -(normal.x * way[0] + normal.y * way[1] + normal.z * way[2]); };
  // The dot product of the normal and a vector towards the eye whose view depth is 1 m, at the pixel's middle and at
  // the centre; per pixel it changes by `right` and `down`. The inverse depth of the tangent plane is proportional to
  // it.
  const Floats right = towards(s.right) * s.pixel, down = -towards(s.up) * s.pixel;
  const Floats ahead =
      towards(s.forward) + (right * (to_floats(at.column) + s.left) + down * (to_floats(at.row) + s.top));
  const Floats there = ahead + right * at.right + down * at.down;
  const Floats depth = surface * (ahead / there);
  const Floats slope = (abs(right) + abs(down)) / there;  // relative change of depth per pixel
  const Floats margin = slope * s.blur + kLeastMargin;
  const Mask behind = close & (there > 0.0f) & (c.depth > depth * (margin + 1.0f));  // not beyond the plane's horizon
  const Floats reach = c.radius + 1.0f, left = 1.0f - slope * reach;
  const Floats deepening = select(left * kHorizon > 1.0f, 1.0f / left, all(kHorizon));
  const Floats needed = depth * (deepening * (hides / surface) + reach * s.pixel);
  Mask deeper = behind & (needed > c.depth);
  const Floats square = at.right * at.right + at.down * at.down;
  const auto is_behind = [&](Floats bent) {
    return c.depth > depth * (margin + bent * square * s.pixel / (there * there) + 1.0f);
  };
  // The greatest sum of the absolute differences of two unit vectors' components is 2 sqrt(3).
  const Mask unsure = deeper & ~is_behind(all(3.47f));
  if (any(unsure)) deeper &= ~unsure | is_behind(bend(s, at.column, at.row, normal, unsure));
  return select(deeper, needed, c.depth);
}

// Calls use(used, number, centers, pixels) for vectors of the records with these numbers. `centers` reads those of a
// vector of numbers.
template <class CentersOf, class Use>
MOTES_INLINE void for_each_center(const image::Settling& s, const std::uint32_t* numbers, std::size_t count,
                                  const CentersOf& centers, const Use& use) {
  for (std::size_t k = 0; k < count; k += kLanes) {
    const Mask used = first_lanes(count - k);
    const Uints number = load_uints(numbers + k) & (Uints)used;
    const Centers c = centers((Ints)number);
    use(used, number, c, nearest_pixels(s, c));
  }
}

// Writes the numbers of those of the records with these numbers that are close to a surface, followed by arbitrary
// numbers up to a whole vector; returns how many they are. Prefetches what settle() will read of these surfaces.
template <class CentersOf>
MOTES_INLINE std::size_t find_close(const image::Settling& s, const std::uint32_t* numbers, std::size_t count,
                                    const CentersOf& centers, std::uint32_t* to) {
  std::size_t found = 0;
  for_each_center(s, numbers, count, centers,
                  [&](const Mask& used, const Uints& number, const Centers& c, const NearestPixels& at)
                      __attribute__((always_inline)) {
                        const Mask close = used & in_block(s, at, c) & is_close(s, at, c, hiding(s, at));
                        const Selected chosen(close);
                        store_selected(to + found, chosen, number);
                        std::uint32_t index[kLanes];
                        store_selected(index, chosen, (Uints)(at.row * image::kSurfaceStride + at.column));
                        for (std::size_t i = 0; i < chosen.number(); ++i) {
                          for (int plane = 0; plane < 4; ++plane)
                            __builtin_prefetch(s.surfaces + plane * s.plane + index[i]);
                        }
                        found += chosen.number();
                      });
  return found;
}

// Writes the numbers and new depths of those of the close records that become deeper, followed by arbitrary values up
// to a whole vector; returns how many they are.
template <class CentersOf>
MOTES_INLINE std::size_t settle(const image::Settling& s, const std::uint32_t* close, std::size_t count,
                                const CentersOf& centers, std::uint32_t* deeper, std::uint32_t* depths) {
  std::size_t found = 0;
  for_each_center(s, close, count, centers,
                  [&](const Mask& used, const Uints& number, const Centers& c, const NearestPixels& at)
                      __attribute__((always_inline)) {
                        const Floats depth = settled(s, at, c, hiding(s, at), used);
                        const Selected changed(used & (depth != c.depth));
                        store_selected(deeper + found, changed, number);
                        store_selected(depths + found, changed, (Uints)depth);
                        found += changed.number();
                      });
  return found;
}

// Reads the centres, radii and depths of records that have sizes.
struct SizedRecords {
  static constexpr std::size_t kMost = 128;

  alignas(64) std::int32_t x[kMost], y[kMost];
  alignas(64) float radius[kMost];
  alignas(64) std::uint32_t depth[kMost];

  MOTES_INLINE void read(const image::Settling& s, const unsigned char* records, std::size_t count) {
    const bool wide = image::is_wide(s.layout);
    for (std::size_t i = 0; i < count; ++i, records += s.record_bytes) {
      const std::uint32_t first = word_at(records), size = word_at(records + s.form.size) & 0xffffu;
      const int coarser = !wide && size >= image::kBigSize ? image::kBigBits : 0;
      x[i] = (wide ? static_cast<std::int32_t>(first) : static_cast<std::int16_t>(first)) << coarser;
      y[i] = (wide ? static_cast<std::int32_t>(word_at(records + 4)) : static_cast<std::int32_t>(first) >> 16)
             << coarser;
      radius[i] = 0.5f / (1 << image::kSizeBits) * static_cast<float>(image::size_units(size));
      depth[i] = word_at(records + s.form.depth);
    }
    for (std::size_t i = count; i % kLanes != 0; ++i) x[i] = y[i] = 0, radius[i] = 0, depth[i] = 0;
  }
};

// Writes the numbers and new depths of the records that become deeper, as settle() does. First it looks for those in
// the range of depths of their block, which are few.
MOTES_INLINE std::size_t settle_all(const image::Settling& s, const unsigned char* records, std::size_t count,
                                    std::uint32_t* deeper, std::uint32_t* depths) {
  constexpr std::size_t kMost = SizedRecords::kMost;
  alignas(64) std::uint32_t position[kMost], depth[kMost], numbers[kMost];
  SizedRecords sized;
  const bool fixed = image::of_fixed_size(s.layout);
  const auto centers = [&](Ints number) {
    if (fixed) return fixed_centers(s, (Uints)gathered(position, number), (Uints)gathered(depth, number));
    const auto ints = [&](const std::int32_t* from) {
      return (Ints)gather(reinterpret_cast<const float*>(from), number);
    };
    return Centers{ints(sized.x), ints(sized.y), gather(sized.radius, number), gathered(sized.depth, number)};
  };
  std::size_t found = 0;
  for (std::size_t first = 0; first < count;
       first += kMost, records += kMost * static_cast<std::size_t>(s.record_bytes)) {
    const std::size_t number = count - first < kMost ? count - first : kMost;
    if (fixed) {
      read_places(s.record_bytes, s.form.depth, records, number, position, depth);
    } else {
      sized.read(s, records, number);
    }
    std::size_t near = 0;
    for (std::size_t i = 0; i < number; i += kLanes) {
      const Ints some = (Ints)(lane_numbers() + static_cast<std::uint32_t>(i));
      const Centers c = centers(some);
      near += squeeze(numbers + near, (Uints)some, in_block(s, nearest_pixels(s, c), c) & first_lanes(number - i));
    }
    near = find_close(s, numbers, near, centers, numbers);
    const std::size_t more = settle(s, numbers, near, centers, deeper + found, depths + found);
    for (std::size_t k = 0; k < more; ++k) deeper[found + k] += static_cast<std::uint32_t>(first);
    found += more;
  }
  return found;
}

}  // namespace motes::MOTES_ISA
