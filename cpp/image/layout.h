// The forms of a record: which one a system's particles take follows from its sprite and the view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "image/grid.h"
#include "image/scene.h"

namespace motes::image {

/// Without depth, where the system is additive and nothing in the picture hides anything:
///   plain        points and discs of fixed size, up to kMaxFootprint pixels
///   sized        each record has its size
///   moving       all sprites but images, while the shutter is open: each record has its size and its streak
/// deep, deep_sized, deep_moving: the same with a depth, for any blend, and for spheres.
/// wide: images, and sizes and streaks in very large pictures (see Grid::far_bits); always with a depth.
/// posed: cards and meshes: wide, and how they are turned.
/// ribbon: wide, and where the ribbon passes.
/// tiled, posed_tiled: images and cards, and which tile of their picture they show.
enum class Layout : std::uint8_t {
  plain,
  deep,
  sized,
  deep_sized,
  moving,
  deep_moving,
  wide,
  posed,
  tiled,
  posed_tiled,
  ribbon
};

struct PlainRecord {
  std::int16_t x, y;  // see Grid::sub_bits
  std::uint8_t color[3], alpha;
};

struct DeepRecord {
  std::int16_t x, y;
  std::uint8_t color[3], alpha;
  std::uint32_t depth;  // bits of the positive float view depth, m
};

/// `x`, `y` and half of the streak (`dx`, `dy`) lead to its two ends; a particle without a streak has dx = dy = 0.
/// |x|, |y| < 2^22, |dx|, |dy| < 2^23.
struct WideRecord {
  std::int32_t x, y;          // middle of the streak, 1/256 px right of and below the centre of the image
  std::uint8_t color[3], alpha;
  std::uint32_t depth;        // bits of the positive float view depth, m
  std::uint16_t size;         // diameter (of images: the longer side), 1/64 px: 2..512 px
  std::uint16_t light;        // part of its alpha that is shown, 1/32768: below 32768 for what is narrower than 2 px
  std::int16_t up_x, up_y;  // the particle's `up` on the screen (y downwards), a unit vector * 32767; 0, 0: unknown
  std::int32_t dx : 24;  // from the start of the streak to its end, 1/256 px
  std::uint32_t gain_low : 8;  // see gain()
  std::int32_t dy : 24;
  std::uint32_t gain_high : 8;

  /// Returns the factor on the light of what lamps make brighter than its colour can say; from 1 on.
  float gain() const {
    const std::uint32_t bits = ((gain_low | gain_high << 8) + kGainOne) << kGainShift;
    float factor;
    __builtin_memcpy(&factor, &bits, sizeof factor);
    return factor;
  }
  /// The upper bits of a float, less those of 1, are what a record has of its gain: low byte, then high byte.
  static constexpr int kGainShift = 12;
  static constexpr std::uint32_t kGainOne = 127u << (23 - kGainShift);
};

/// Its `size` says only how far its middle may be from what hides it; up_x and up_y are one number, its turn about the
/// camera's axes while the shutter is open: see unpack_turn() in image/moments.h.
struct PosedRecord : WideRecord {
  std::int16_t turn[4];  // a quaternion * 32767, from its own axes to the camera's: right, up, back
  float scale;           // m per unit of length: of a card, its longer side
};

/// A place that a ribbon passes through.
struct RibbonPoint {
  float x, y;    // px right of and below the centre of the image
  float depth;   // m
  float along;   // part of the ribbon's length that lies before it; above 1: beyond its end
  std::int16_t then_x, then_y;  // from here to where it was when the shutter opened, 1/16 px
  std::uint8_t tint[4];  // parts of the record's colour that are seen here, 1/255
};

/// Its `depth` is that of the nearest of its points; points beyond `count` are all 0. `up_x` is 1 where it does not
/// fade; `up_y` is the part of its length that its head ran while the shutter was open, in units of kRunUnit.
struct RibbonRecord : WideRecord {
  float width;  // m
  std::uint32_t count;
  RibbonPoint point[kMostPast + 1];  // from the particle backwards
};

inline constexpr float kRunUnit = 1.0f / 4096, kMostRun = 0.98f;

static_assert(sizeof(PlainRecord) == 8 && sizeof(DeepRecord) == 12 && sizeof(WideRecord) == 32);
static_assert(sizeof(PosedRecord) == 44 && sizeof(RibbonRecord) == 40 + 24 * (kMostPast + 1));

/// Tiled records end with the number of a tile, 1/256: the low 8 bits say how much of the next tile is mixed in.
inline constexpr int kTileNumberBits = 8;

/// How far, px, a card or a mesh may reach from its middle; what is beyond is not drawn.
inline constexpr float kMostPosedReach = 2048;

/// Where the other layouts keep what. They begin with a position of two 16-bit
/// numbers (see Grid::sub_bits, far_bits), then colour and alpha. Sizes and
/// light are those of a WideRecord; a way is half of the streak, in the units
/// of the position. Records of a system that has one colour can do without it:
/// what is behind it moves up.
struct RecordForm {
  int bytes;
  int color, depth, size, way; // 0: there is none
  int tile = 0;  // number of a tile
};
constexpr RecordForm form(Layout layout, bool colored = true) {
  const int c = colored ? 4 : 0;
  switch (layout) {
    case Layout::plain: return {4 + c, c, 0, 0, 0};
    case Layout::deep: return {8 + c, c, 4 + c, 0, 0};
    case Layout::sized: return {8 + c, c, 0, 4 + c, 0};
    case Layout::deep_sized: return {12 + c, c, 4 + c, 8 + c, 0};
    case Layout::moving: return {12 + c, c, 0, 4 + c, 8 + c};
    case Layout::deep_moving: return {16 + c, c, 4 + c, 8 + c, 12 + c};
    case Layout::wide: break;
    case Layout::posed: return {sizeof(PosedRecord), 8, 12, 16, 24};
    case Layout::ribbon: return {sizeof(RibbonRecord), 8, 12, 16, 24};
    case Layout::tiled: return {sizeof(WideRecord) + 4, 8, 12, 16, 24, sizeof(WideRecord)};
    case Layout::posed_tiled: return {sizeof(PosedRecord) + 4, 8, 12, 16, 24, sizeof(PosedRecord)};
  }
  return {sizeof(WideRecord), 8, 12, 16, 24};
}
/// Whether records begin with a WideRecord. These have colours: they are large anyway.
constexpr bool is_wide(Layout layout) { return layout >= Layout::wide; }
constexpr bool may_lack_color(Layout layout) { return !is_wide(layout); }
constexpr bool has_depth(Layout layout) { return form(layout).depth != 0; }
constexpr bool of_fixed_size(Layout layout) { return layout == Layout::plain || layout == Layout::deep; }

inline constexpr int kWideBits = 8; // of a pixel in WideRecord::x, y, dx, dy
inline constexpr int kSizeBits = 6; // of a pixel in WideRecord::size
inline constexpr std::uint16_t kAllLight = 1 << 15; // WideRecord::light of what is not narrower than 2 px

/// Three floats, m/s: they follow a record of an opaque system where the view has kVelocityLayer.
inline constexpr std::size_t kVelocityBytes = 12;
bool with_velocity(const Sprite& sprite, const View& view);

/// Whether records of a picture are drawn in the order of their depths, which needs each one's colour with it.
bool in_order_of_depth(std::span<const Sprite> sprites);

/// Whether anything in a picture hides what is behind it: objects, or a system that is opaque or blends by alpha.
bool anything_hides(const View& view, std::span<const Sprite> sprites);

/// Cards, meshes and ribbons: they stand in space.
bool is_posed(const Sprite& sprite);

/// Points, and discs and spheres of one pixel.
bool drawn_as_point(const Sprite& sprite);

/// Pixels of a sprite whose particles all have the same size; 0: they have
/// their own. What is drawn as a point is 2 px wide: as much light as its 2x2
/// pixels get.
float diameter_of(const Sprite& sprite, int height);

/// Whether lamps may make particles brighter than their colours can say: then records have a gain, and are wide.
bool has_gain(const Sprite& sprite, const View& view);

/// A sprite as a camera sees it: through a lens opaque particles are blended from far to near, since those that are out
/// of focus let some of the light behind them through.
Sprite as_seen(Sprite sprite, const View& view);

/// Equal on every rank, as view and sprites are. `any_depth`: see
/// anything_hides().
Layout layout(const Sprite& sprite, const View& view, bool any_depth);

/// Bytes of one record, without velocity.
constexpr std::size_t record_bytes(Layout layout, bool colored = true) {
  return static_cast<std::size_t>(form(layout, colored).bytes);
}

/// A record of any layout but plain and deep, in a picture of which positions
/// have these bits. `color`: what it gets where it has none. Always inlined:
/// files that are compiled once for each instruction set use it.
__attribute__((always_inline)) inline WideRecord wide_record(const RecordForm& form, int bits, const std::byte* bytes,
                                                             std::uint32_t color = 0) {
  WideRecord r{};
  if (form.color == 8) {
    __builtin_memcpy(&r, bytes, sizeof r);
    return r;
  }
  const auto pair = [&](int at, std::int32_t& x, std::int32_t& y, int shift) {
    std::int16_t both[2];
    __builtin_memcpy(both, bytes + at, 4);
    x = both[0] * (1 << shift);
    y = both[1] * (1 << shift);
  };
  pair(0, r.x, r.y, 8 - bits);
  if (form.color != 0) __builtin_memcpy(&color, bytes + form.color, 4);
  __builtin_memcpy(r.color, &color, 4);
  if (form.depth != 0) __builtin_memcpy(&r.depth, bytes + form.depth, 4);
  __builtin_memcpy(&r.size, bytes + form.size, 4);
  if (form.way != 0) {
    std::int32_t dx, dy;
    pair(form.way, dx, dy, 9 - bits);
    r.dx = dx;
    r.dy = dy;
  }
  return r;
}

}  // namespace motes::image
