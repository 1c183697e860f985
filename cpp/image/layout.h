// Layouts of records. A system's sprite and the view determine the layout of its records.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "image/grid.h"
#include "image/scene.h"

namespace motes::image {

/// Without depth, for additive systems in pictures where nothing hides anything:
///   plain        points and discs of fixed size, up to kMaxFootprint pixels
///   sized        points and discs whose records have sizes
///   moving       points and discs while the shutter is open: records have sizes and streaks
/// deep, deep_sized, deep_moving: the same with a depth, for any blend mode, and for spheres.
/// wide: images, sprites lit by lamps, and sizes and streaks in very large pictures (see Grid::far_bits); with a depth.
/// posed: cards and meshes: a wide record and its orientation.
/// ribbon: a wide record and the points of the ribbon.
/// tiled, posed_tiled: a wide or posed record and a tile number, for images and cards whose picture has tiles.
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

/// The streak runs from (x, y) - (dx, dy) / 2 to (x, y) + (dx, dy) / 2; without a streak dx = dy = 0.
/// |x|, |y| < 2^22, |dx|, |dy| < 2^23.
struct WideRecord {
  std::int32_t x, y;          // middle of the streak, 1/256 px right of and below the centre of the image
  std::uint8_t color[3], alpha;
  std::uint32_t depth;        // bits of the positive float view depth, m
  std::uint16_t size;         // diameter (of images: the longer side), at least 2 px: see size_units()
  std::uint16_t light;        // factor on alpha, 1/32768; below 32768 for sprites narrower than 2 px
  std::int16_t up_x, up_y;  // the particle's `up` on the screen (y downwards), a unit vector * 32767; 0, 0: unknown
  std::int32_t dx : 24;  // from the start of the streak to its end, 1/256 px
  std::uint32_t gain_low : 8;  // see gain()
  std::int32_t dy : 24;
  std::uint32_t gain_high : 8;

  /// Returns the factor, at least 1, by which lamps make the particle brighter than its colour can express.
  float gain() const {
    const std::uint32_t bits = ((gain_low | gain_high << 8) + kGainOne) << kGainShift;
    float factor;
    __builtin_memcpy(&factor, &bits, sizeof factor);
    return factor;
  }
  /// A record stores the upper bits of its gain (a float) minus those of 1.0f: low byte, then high byte.
  static constexpr int kGainShift = 12;
  static constexpr std::uint32_t kGainOne = 127u << (23 - kGainShift);
};

/// A card or a mesh. `size` serves only to test its middle against surfaces (see raster/behind.h). `up_x` and `up_y`
/// together hold its rotation about the camera's axes while the shutter is open: see unpack_turn() in image/moments.h.
struct PosedRecord : WideRecord {
  std::int16_t turn[4];  // quaternion * 32767, from its own axes to the camera's: right, up, back
  float scale;           // m per unit of length of a mesh; longer side of a card, m
};

/// A point that a ribbon passes through.
struct RibbonPoint {
  float x, y;    // px right of and below the centre of the image
  float depth;   // m
  float along;   // fraction of the ribbon's length before this point; above 1: beyond its end
  std::int16_t then_x, then_y;  // from here to where it was when the shutter opened, 1/16 px
  std::uint8_t tint[4];  // factors on the record's colour at this point, 1/255
};

/// A ribbon. `depth` is that of its nearest point. `up_y` is the fraction of
/// its length that its head travelled while the shutter was open, in units of kRunUnit.
struct RibbonRecord : WideRecord {
  float width;  // m
  std::uint32_t count;
  RibbonPoint point[kMostPast + 1];  // from the particle backwards; all 0 beyond `count`
};

inline constexpr float kRunUnit = 1.0f / 4096, kMostRun = 0.98f;

static_assert(sizeof(PlainRecord) == 8 && sizeof(DeepRecord) == 12 && sizeof(WideRecord) == 32);
static_assert(sizeof(PosedRecord) == 44 && sizeof(RibbonRecord) == 40 + 24 * (kMostPast + 1));

/// Tiled records end with a tile number in units of 1/256: the low 8 bits are the weight of the next tile.
inline constexpr int kTileNumberBits = 8;

/// Greatest distance, px, that a card or a mesh reaches from its middle; parts beyond it are not drawn.
inline constexpr float kMostPosedReach = 2048;

/// Offsets, in bytes, of a record's members; 0: the member is absent. Records that are not wide begin with a position
/// of two 16-bit numbers (see Grid::sub_bits, far_bits), then colour and alpha; their size and light are those of a
/// WideRecord, and `way` is half of the streak, in the units of the position. If all particles of a system have one
/// colour, its records may omit it; the members after it move up.
struct RecordForm {
  int bytes;  // of the whole record
  int color, depth, size, way;
  int tile = 0;  // tile number
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
/// Returns whether records begin with a WideRecord. Wide records always have a colour.
constexpr bool is_wide(Layout layout) { return layout >= Layout::wide; }
constexpr bool may_lack_color(Layout layout) { return !is_wide(layout); }
constexpr bool has_depth(Layout layout) { return form(layout).depth != 0; }
constexpr bool of_fixed_size(Layout layout) { return layout == Layout::plain || layout == Layout::deep; }

inline constexpr int kWideBits = 8; // fractional bits of WideRecord::x, y, dx, dy
inline constexpr int kSizeBits = 6; // fractional bits of WideRecord::size

/// Sizes from kBigSize (512 px) on grow in units of 16/64 px. Of records that are not wide, positions and streaks of
/// such sprites are in units kBigBits larger, so that they may begin farther outside the image.
inline constexpr std::uint32_t kBigSize = 1 << 15;
inline constexpr int kBigSizeBits = 4, kBigBits = 2;
/// Greatest diameter of a record, px.
inline constexpr int kMostDiameter = 8192;
static_assert(((kMostDiameter << kSizeBits) - kBigSize) >> kBigSizeBits < kBigSize);

/// Returns a WideRecord::size in 1/64 px.
constexpr std::int32_t size_units(std::uint32_t size) {
  if (size < kBigSize) [[likely]]
    return static_cast<std::int32_t>(size);
  return static_cast<std::int32_t>(kBigSize + ((size - kBigSize) << kBigSizeBits));
}
inline constexpr std::uint16_t kAllLight = 1 << 15; // WideRecord::light of sprites at least 2 px wide

/// Bytes of a velocity (three floats, m/s), which follows each record of an opaque system if the view has
/// kVelocityLayer, and of a liquid that foams.
inline constexpr std::size_t kVelocityBytes = 12;
bool with_velocity(const Sprite& sprite, const View& view);

/// Returns whether a picture's records are drawn in order of depth; each of them then needs its own colour.
bool in_order_of_depth(std::span<const Sprite> sprites);

/// Returns whether a picture has anything that hides what is behind it: objects, or a system that is opaque or blends
/// by alpha.
bool anything_hides(const View& view, std::span<const Sprite> sprites);

/// Returns whether a sprite is drawn as an object in space: cards, meshes and ribbons are.
bool is_posed(const Sprite& sprite);

/// Returns whether a sprite is drawn as a point: points, and discs and spheres of one pixel, are.
bool drawn_as_point(const Sprite& sprite);

/// Returns the diameter, px, that all particles of a sprite have; 0 if each has its own. Sprites drawn as points have
/// 2 px, because their light goes to 2x2 pixels.
float diameter_of(const Sprite& sprite, int height);

/// Returns whether light may make images brighter than their colours can express before they are painted. If so,
/// records are wide and have a gain.
bool has_gain(const Sprite& sprite, const View& view);

/// Returns whether the light of sun and sky has no colour: then one number is that on a sphere's point (see Daylight).
bool has_grey_light(const View& view);

/// Returns whether the painter lights each point of a sprite: lit spheres, cards and meshes, and those that reflect.
/// Other lit sprites get their light when they are projected.
bool lit_by_painter(const Sprite& sprite);

/// Returns whether the painter fills in the fog, which must not be multiplied by a sprite's shade or picture.
bool fogged_by_painter(const Sprite& sprite, const View& view);

/// Returns a sprite as a camera sees it: through a lens, pictures that face it are cards, which are blurred in space.
/// Opaque ones stay as they are: see image/exposures.h. In a preview, diameters in pixels shrink with the picture.
Sprite as_seen(Sprite sprite, const View& view);

/// Returns whether painters blur the sprite by its depth. All others that a lens blurs are projected larger and
/// fainter.
bool blurs_in_painter(const Sprite& sprite);

/// Returns the layout of a sprite's records; equal on every rank, as view and sprites are. `any_depth`: the result of
/// anything_hides().
Layout layout(const Sprite& sprite, const View& view, bool any_depth);

/// Returns the bytes of one record, without velocity.
constexpr std::size_t record_bytes(Layout layout, bool colored = true) {
  return static_cast<std::size_t>(form(layout, colored).bytes);
}

/// Expands a record of any layout but plain and deep. `bits`: fractional bits of the picture's positions. `color`: for
/// records without one. Always inlined, because files compiled once for each instruction set use it.
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
  __builtin_memcpy(&r.size, bytes + form.size, 4);
  if (form.color != 0) __builtin_memcpy(&color, bytes + form.color, 4);
  __builtin_memcpy(r.color, &color, 4);
  if (form.depth != 0) __builtin_memcpy(&r.depth, bytes + form.depth, 4);
  if (form.way != 0) {
    std::int32_t dx, dy;
    pair(form.way, dx, dy, 9 - bits);
    r.dx = dx;
    r.dy = dy;
  }
  if (__builtin_expect(r.size >= kBigSize, 0)) {
    constexpr int kLarger = 1 << kBigBits;
    r.x *= kLarger;
    r.y *= kLarger;
    r.dx = r.dx * kLarger;
    r.dy = r.dy * kLarger;
  }
  return r;
}

}  // namespace motes::image
