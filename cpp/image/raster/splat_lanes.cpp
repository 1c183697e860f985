// Compiled once for each instruction set: see simd/simd.h for the rules. Sums are integers, so they do not depend on
// the order of records.
#include "image/raster/splat_lanes.h"

#include "image/balls/ball_lanes.h"
#include "image/grid.h"
#include "image/layout.h"
#include "image/raster/opaque_lanes.h"
#include "image/raster/pixel_lanes.h"
#include "image/raster/point_lanes.h"
#include "image/raster/settle_lanes.h"
#include "image/raster/tested_lanes.h"

namespace motes::MOTES_ISA {
namespace {

using image::kLightStride;
using image::kPixelStride;
using image::Splat;
using image::TilePlanes;

// Where a footprint begins: offsets in the planes of the tile, its first row in tables, and its unit in Splat::balls.
struct FootprintPlace {
  std::ptrdiff_t light, pixel;
  int row, unit;
};

// Finds where a record's footprint begins; returns false if it does not touch this tile.
template <bool kBalls>
MOTES_INLINE bool place(const Splat& s, std::uint32_t position, FootprintPlace& at) {
  const int x = static_cast<std::int16_t>(position & 0xffffu) - s.origin_x;
  const int y = static_cast<std::int16_t>(position >> 16) - s.origin_y;
  const int column = x >> s.sub_bits;
  const int row = y >> s.sub_bits;
  const unsigned reach = static_cast<unsigned>(s.size + image::kTile - 1);
  if (static_cast<unsigned>(column + s.size - 1) >= reach || static_cast<unsigned>(row + s.size - 1) >= reach) {
    return false;
  }
  at.light = static_cast<std::ptrdiff_t>(row) * kLightStride + 3 * column;
  at.pixel = static_cast<std::ptrdiff_t>(row) * kPixelStride + column;
  const int up = 4 - s.sub_bits;
  const int down = 4 - s.phase_bits;
  const int phase_x = (x << up & 15) >> down;
  const int phase_y = (y << up & 15) >> down;
  const int phase = phase_y << s.phase_bits | phase_x;
  at.row = phase * s.size;
  at.unit = kBalls ? ball_units(*s.balls->look, column, row, phase) : 0;
  return true;
}

template <int kVectors, bool kSaturating, bool kColored>
void add_records(const TilePlanes& planes, const Splat& task, const unsigned char* records, std::size_t count) {
  const Splat s = task;
  const TilePlanes tile = planes;
  const Channels channel = channels();
  const RecordLight of_all = light_of(channel, s.color);
  const unsigned char* end = records + count * static_cast<std::size_t>(s.record_bytes);
  for (const unsigned char* r = records; r != end; r += s.record_bytes) {
    FootprintPlace at;
    if (!place<false>(s, word_at(r), at)) continue;
    const RecordLight light = kColored ? light_of(channel, word_at(r + 4)) : of_all;
    const std::uint8_t* weights = s.weights + static_cast<std::ptrdiff_t>(at.row) * s.row_bytes;
    add_open<kVectors, kSaturating>(s, light, weights, tile.light + at.light);
  }
}

// Adds points that nothing hides.
template <bool kSaturating, bool kColored>
void add_points(const TilePlanes& planes, const Splat& task, const unsigned char* records, std::size_t count) {
  constexpr std::size_t kBytes = kPointBytes<kColored>;
  const Splat s = task;
  const TilePlanes tile = planes;
  const Channels channel = channels();
  const auto draw = [&](const Points& points, std::size_t number) {
    if (add_vector<kSaturating, kColored>(tile, s, channel, points, records, static_cast<int>(number))) return;
    add_records<kPointVectors, kSaturating, kColored>(tile, s, records, number);
  };
  for (; count >= kLanes; count -= kLanes, records += kLanes * kBytes) draw(whole_points<kColored>(records), kLanes);
  if (count != 0) draw(some_points<kColored>(records, static_cast<int>(count)), count);
}

// Returns whether records in front of everything in the tile are mixed with others. Then testing the pixels of all is
// cheaper than mispredicted branches.
bool is_mixed(const TilePlanes& tile, const Splat& s, const unsigned char* records, std::size_t count) {
  constexpr std::size_t kSample = 32;
  const std::size_t number = count < kSample ? count : kSample;
  std::size_t nearer = 0;
  for (std::size_t i = 0; i < number; ++i, records += s.record_bytes) nearer += word_at(records + 8) <= tile.nearest;
  return nearer * 8 > number && nearer * 8 < number * 7;
}

template <int kVectors, bool kSaturating, bool kDepth, bool kFade>
void over_records(const TilePlanes& planes, const Splat& task, const unsigned char* records, std::size_t count) {
  const Splat s = task;
  const TilePlanes tile = planes;
  const Channels channel = channels();
  const Spread spreading = spread();
  const bool flat = s.balls == nullptr;
  const bool mixed = kDepth && !kFade && is_mixed(tile, s, records, count);
  const unsigned char* end = records + count * static_cast<std::size_t>(s.record_bytes);
  for (const unsigned char* r = records; r != end; r += s.record_bytes) {
    FootprintPlace at;
    if (!(flat ? place<false>(s, word_at(r), at) : place<true>(s, word_at(r), at))) continue;
    const std::uint32_t depth = kDepth ? word_at(r + 8) : 0;
    if (kDepth && depth > tile.farthest) continue;
    const bool test = kDepth && (kFade || mixed || depth > tile.nearest);
    const std::uint32_t color = word_at(r + 4);
    const RecordLight light = light_of(channel, color);
    const Uints alpha = all_uints(color >> 24);
    const std::uint8_t* cover = s.weights + static_cast<std::ptrdiff_t>(at.row) * s.row_bytes;
    const std::uint8_t* weights = flat ? cover : ball_at(*s.balls, at.unit);
    std::uint32_t* to = tile.light + at.light;
    const std::uint32_t* wall = tile.depth + at.pixel;
    for (int row = 0; row < s.size; ++row) {
      for (int j = 0; j < kVectors; ++j) {
        const Uints weight = load_bytes(weights + j * kWidth);
        const Uints covered = flat ? weight : load_bytes(cover + j * kWidth);
        Uints more = multiply_short(weight, light.part[j % 3]);
        Uints opacity = opacity_of(multiply_short(covered, alpha));
        if (test) {
          const Uints here = load_spread(spreading, wall, j);
          const Uints seen = (Uints)((Ints)here >= (Ints)all_uints(depth));
          if (kFade) {
            const Uints left = faded(here, depth, s.fade);
            more = more * left >> 12;
            opacity = opacity * left >> 12;
          }
          more &= seen;
          opacity &= seen;
        }
        const Uints kept = behind(in_register(load_uints(to + j * kWidth)), opacity);
        Uints sum = kept + more;
        if (kSaturating) sum |= (Uints)(sum < kept);
        store_uints(to + j * kWidth, sum);
      }
      to += kLightStride;
      wall += kPixelStride;
      weights += s.row_bytes;
      cover += s.row_bytes;
    }
  }
}

template <int kVectors, bool kSaturating, bool kOver, bool kDepth, bool kFade>
MOTES_INLINE void blend_records(const TilePlanes& tile, const Splat& s, const unsigned char* records,
                                std::size_t count) {
  if constexpr (kOver) {
    over_records<kVectors, kSaturating, kDepth, kFade>(tile, s, records, count);
  } else if constexpr (kDepth) {
    add_among<kVectors, kSaturating, kFade>(tile, s, records, count);
  } else if (s.balls != nullptr) {
    add_balls<kVectors, kSaturating>(tile, s, records, count);
  } else if (s.form.color != 0) {
    add_records<kVectors, kSaturating, true>(tile, s, records, count);
  } else {
    add_records<kVectors, kSaturating, false>(tile, s, records, count);
  }
}

template <int kVectors, bool kSaturating, bool kOver>
MOTES_INLINE void blend_in(const TilePlanes& tile, const Splat& s, const unsigned char* records, std::size_t count) {
  const bool depth = s.form.depth != 0 && tile.hides;
  if (!depth) return blend_records<kVectors, kSaturating, kOver, false, false>(tile, s, records, count);
  if (!(s.fade > 0)) return blend_records<kVectors, kSaturating, kOver, true, false>(tile, s, records, count);
  blend_records<kVectors, kSaturating, kOver, true, true>(tile, s, records, count);
}

// Step between the numbers of vectors per row for which a loop is compiled. With four lanes, which only old processors
// have, there is one loop per 16 lanes (rows of weights are padded to that), and all saturate, to save compile time.
constexpr int kStep = kWidth == 4 ? 4 : 1;

template <int kVectors, bool kOver>
void blend_from(const TilePlanes& tile, const Splat& s, const unsigned char* records, std::size_t count) {
  if constexpr (kVectors * kWidth < 3 * image::kMaxFootprint) {
    if (kVectors * kWidth < 3 * s.size) return blend_from<kVectors + kStep, kOver>(tile, s, records, count);
  }
  if constexpr (kWidth > 4) {
    if (!s.saturating) return blend_in<kVectors, false, kOver>(tile, s, records, count);
  }
  blend_in<kVectors, true, kOver>(tile, s, records, count);
}

template <bool kColored>
void add_points_any(const TilePlanes& tile, const Splat& s, const unsigned char* records, std::size_t count) {
  s.saturating ? add_points<true, kColored>(tile, s, records, count)
               : add_points<false, kColored>(tile, s, records, count);
}

void add_any(const TilePlanes& tile, const Splat& s, const unsigned char* records, std::size_t count) {
  if (s.size != 2 || s.form.depth != 0) return blend_from<kStep, false>(tile, s, records, count);
  s.form.color != 0 ? add_points_any<true>(tile, s, records, count) : add_points_any<false>(tile, s, records, count);
}
void over_any(const TilePlanes& tile, const Splat& s, const unsigned char* records, std::size_t count) {
  blend_from<kStep, true>(tile, s, records, count);
}

// Right shifts that bring red, green, blue of a surface to the lowest byte, in the order of the lanes of light.
struct Shifts {
  Uints part[3];
};
MOTES_INLINE Shifts channel_shifts() {
  Shifts s;
  for (int j = 0; j < 3; ++j) {
    for (int lane = 0; lane < kWidth; ++lane) s.part[j][lane] = static_cast<std::uint32_t>((lane + kWidth * j) % 3 * 8);
  }
  return s;
}

// Returns the light of a surface: that of an additive record with its shade as alpha and a weight of 255.
MOTES_INLINE Uints surface_light(Uints surface, Uints shift) {
  return ((multiply_short(surface >> shift & 0xffu, surface >> 24) + 8u) >> 4) * 255u;
}

// Writes the light of the surfaces of a row that are brighter than white.
__attribute__((noinline)) void show_bright(const std::uint32_t* surfaces, int columns, std::uint32_t* light) {
  for (int x = 0; x < columns; ++x) {
    const std::uint32_t surface = surfaces[x];
    if (surface == 0 || surface >> 24 != 0) continue;
    const auto unit = static_cast<float>(1u << (surface >> image::kBrightExponent)) * static_cast<float>(image::kUnit);
    const float parts[3] = {static_cast<float>(surface >> image::kBrightRed & 127u) * (1.0f / 127),
                            static_cast<float>(surface >> image::kBrightGreen & 127u) * (1.0f / 127),
                            static_cast<float>(surface & 63u) * (1.0f / 63)};
    for (int c = 0; c < 3; ++c) {
      const float sum = parts[c] * unit + 0.5f;
      light[3 * x + c] = sum < image::kMostScenery ? static_cast<std::uint32_t>(sum) : 0xffffffffu;
    }
  }
}

image::DepthRange show_surfaces(const TilePlanes& tile, int rows, int columns) {
  const Spread spreading = spread();
  const Shifts shifts = channel_shifts();
  Ints least = (Ints)all_uints(0x7f800000u), greatest{};
  for (int row = 0; row < rows; ++row) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(row) * kPixelStride;
    // The row's visible surfaces, 0 elsewhere (a visible one has a shade of at least 1). Whole vectors are written;
    // columns beyond the last do not matter.
    std::uint32_t seen[image::kTile + 2 * kLanes];
    Mask bright{};
    for (int x = 0; x < columns; x += kWidth) {
      Uints surface, front;
      split(tile.surfaces + first + x, surface, front);
      const Uints depth = load_uints(tile.depth + first + x);
      // Depths are bits of positive floats; "no surface" lies behind the solid.
      const Mask shows = (Ints)front <= (Ints)depth;
      store_uints(seen + x, surface & (Uints)shows);
      bright |= shows & (Mask)(surface - 1u < 0xffffffu);
      store_uints(tile.depth + first + x, (front & (Uints)shows) | (depth & ~(Uints)shows));
    }
    for (int x = columns; x < columns + kWidth; ++x) seen[x] = 0;
    std::uint32_t* light = tile.light + static_cast<std::ptrdiff_t>(row) * kLightStride;
    for (int x = 0; x < columns; x += kWidth, light += 3 * kWidth) {
      for (int j = 0; j < 3; ++j) {
        const Uints surface = load_spread(spreading, seen + x, j);
        const Uints shows = (Uints)(surface != 0u);
        const Uints under = load_uints(light + j * kWidth) & ~shows;
        store_uints(light + j * kWidth, (surface_light(surface, shifts.part[j]) & shows) | under);
      }
      const int inside = columns - x < kWidth ? columns - x : kWidth;
      Ints depth = (Ints)load_uints(tile.depth + first + x);
      if (inside < kWidth) {
        for (int i = inside; i < kWidth; ++i) depth[i] = depth[0];
      }
      least = depth < least ? depth : least;
      greatest = depth > greatest ? depth : greatest;
    }
    if (any(bright)) show_bright(seen, columns, tile.light + static_cast<std::ptrdiff_t>(row) * kLightStride);
  }
  image::DepthRange range{0x7f800000u, 0};
  for (int lane = 0; lane < kWidth; ++lane) {
    const auto low = static_cast<std::uint32_t>(least[lane]), high = static_cast<std::uint32_t>(greatest[lane]);
    range.nearest = low < range.nearest ? low : range.nearest;
    range.farthest = high > range.farthest ? high : range.farthest;
  }
  return range;
}

std::uint32_t brightest(const std::uint32_t* first, int rows, int lanes) {
  std::uint32_t most = 0;
  for (int row = 0; row < rows; ++row) {
    const std::uint32_t* light = first + static_cast<std::ptrdiff_t>(row) * image::kLightStride;
    int i = 0;
    Uints greatest{};
    for (; i + kWidth <= lanes; i += kWidth) {
      const Uints v = load_uints(light + i);
      const Uints more = (Uints)(v > greatest);
      greatest = (v & more) | (greatest & ~more);
    }
    for (int lane = 0; lane < kWidth; ++lane) most = greatest[lane] > most ? greatest[lane] : most;
    for (; i < lanes; ++i) most = light[i] > most ? light[i] : most;
  }
  return most;
}

// The exponent and first mantissa bits of a float form a logarithm in steps. Halved, a sum fits a signed integer.
MOTES_INLINE Ints tone_index(Uints light) {
  const Ints bits = (Ints)to_floats((Ints)(light >> 1));
  const Ints index = (bits >> (23 - image::kToneBits)) - (127 << image::kToneBits);
  return index & (index > 0);
}

using ToneNumbers = std::uint16_t __attribute__((vector_size(2 * MOTES_LANES)));
static_assert(image::kToneEntries <= 1 << 16);

constexpr std::size_t kToneRow = 3 * image::kTile;

// What the dither of each lane of a row has more than its first pixel's.
struct DitherSteps {
  std::uint32_t of[kToneRow + kLanes];
};
constexpr DitherSteps kDitherSteps = [] {
  DitherSteps steps{};
  for (std::size_t i = 0; i < kToneRow + kLanes; ++i) {
    steps.of[i] = static_cast<std::uint32_t>(i / 3) * image::kDitherAcross;
  }
  return steps;
}();

// Returns the thresholds of lanes `lane`, `lane` + 1, ... of a row; `first`: the dither of its first pixel.
MOTES_INLINE Uints thresholds(std::uint32_t first, std::size_t lane) {
  const Uints part = (load_uints(kDitherSteps.of + lane) + first) >> 24;
  return part - (part >> 3) + std::uint32_t{image::kLeastThreshold};
}

// Converts at most kToneRow lanes and returns how many. It first stores the indices of all entries, which is faster
// than extracting them from vectors; then it writes eight entries as one word, because the picture is not in the caches
// and fewer stores wait for it.
std::size_t tone_row(const std::uint32_t* light, std::size_t lanes, std::uint32_t dither, const std::uint16_t* table,
                     std::uint8_t* to) {
  const std::size_t count = lanes < kToneRow ? lanes : kToneRow;
  std::uint16_t numbers[kToneRow + kLanes], dithers[kToneRow + kLanes];
  for (std::size_t i = 0; i < count; i += kLanes) {
    const ToneNumbers dithered = __builtin_convertvector(thresholds(dither, i), ToneNumbers);
    __builtin_memcpy(dithers + i, &dithered, sizeof dithered);
  }
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    const ToneNumbers some = __builtin_convertvector(tone_index(load_uints(light + i)), ToneNumbers);
    __builtin_memcpy(numbers + i, &some, sizeof some);
  }
  for (; i < count; ++i) numbers[i] = static_cast<std::uint16_t>(tone_index(all_uints(light[i]))[0]);
  const auto shown_at = [&](std::size_t k) {
    return static_cast<std::uint64_t>((table[numbers[k]] + dithers[k]) >> 8);
  };
  std::size_t shown = 0;
  for (; shown + 8 <= count; shown += 8) {
    std::uint64_t eight = 0;
    for (std::size_t k = 8; k-- > 0;) eight = eight << 8 | shown_at(shown + k);
    __builtin_memcpy(to + shown, &eight, sizeof eight);
  }
  for (; shown < count; ++shown) to[shown] = static_cast<std::uint8_t>(shown_at(shown));
  return count;
}

void tone(const std::uint32_t* light, std::size_t count, int x, int y, const std::uint16_t* table, std::uint8_t* to) {
  auto dither =
      static_cast<std::uint32_t>(x) * image::kDitherAcross + static_cast<std::uint32_t>(y) * image::kDitherDown;
  for (std::size_t i = 0; i < count; dither += image::kTile * image::kDitherAcross) {
    i += tone_row(light + i, count - i, dither, table, to + i);
  }
}

}  // namespace

extern const image::SplatLanes splat_lanes = {add_any,       over_any,  opaque_any, measure_surfaces,
                                              show_surfaces, brightest, tone,       settle_all};

}  // namespace motes::MOTES_ISA
