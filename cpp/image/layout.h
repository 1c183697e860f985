// The forms of a record: which one a system's particles take follows from its sprite and the view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "image/scene.h"

namespace motes::image {

/// plain: additive points and discs of fixed size, where nothing in the picture hides anything. deep: the same with a
/// depth, of any kind but images, in any blend. wide: everything else: sizes in metres, in parts of the picture's
/// height or above kMaxFootprint pixels, images, and all sprites while the shutter is open.
enum class Layout : std::uint8_t { plain, deep, wide };

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
  std::int32_t dx, dy;  // from the start of the streak to its end, 1/256 px
};

static_assert(sizeof(PlainRecord) == 8 && sizeof(DeepRecord) == 12 && sizeof(WideRecord) == 32);

inline constexpr int kWideBits = 8;  // of a pixel in WideRecord::x, y, dx, dy
inline constexpr int kSizeBits = 6;  // of a pixel in WideRecord::size
inline constexpr std::uint16_t kAllLight = 1 << 15;  // WideRecord::light of what is not narrower than 2 px

/// Three floats, m/s: they follow a record of an opaque system where the view has kVelocityLayer.
inline constexpr std::size_t kVelocityBytes = 12;
bool with_velocity(const Sprite& sprite, const View& view);

/// Whether anything in a picture hides what is behind it: objects, or a system that is opaque or blends by alpha.
bool anything_hides(const View& view, std::span<const Sprite> sprites);

/// Equal on every rank, as view and sprites are. `any_depth`: see anything_hides().
Layout layout(const Sprite& sprite, const View& view, bool any_depth);

/// Bytes of one record, without velocity.
constexpr std::size_t record_bytes(Layout layout) {
  return layout == Layout::plain  ? sizeof(PlainRecord)
         : layout == Layout::deep ? sizeof(DeepRecord)
                                  : sizeof(WideRecord);
}

}  // namespace motes::image
