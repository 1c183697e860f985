// Weights of streaks: stamps, reused from record to record, and the Cover, which accumulates those of one colour.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/tile_planes.h"

namespace motes::image {

/// Holds the weights of one streak: of a sprite of one size, one length and direction, at one of 16 sub-pixel
/// positions. They depend only on the key, so it does not matter when they were computed. A point is brighter than a
/// disc of its size (2 px), so its key has size 1, which no disc has.
///
/// Rows are stored in pairs. A block is 8 pixels of both rows, whose weights alternate; a pair has one block per strip:
///
///   pair p, strip s:  upper row  u0 u1 ... u7     block = u0 l0 u1 l1 ... u7 l7  (16 bytes)
///                     lower row  l0 l1 ... l7
///   weights:          strip 0: blocks of pairs 0 .. pairs-1, then strip 1: ...
struct alignas(64) Stamp {
  static constexpr int kPairs = 16;
  static constexpr int kBlocks = 48;
  static constexpr int kBlock = 16;   // weights
  static constexpr int kNarrow = 5;

  std::uint32_t key = 0;             // 0: none
  std::int8_t first = 0;             // first row, relative to the row of the streak's middle
  std::int8_t left = 0, right = 0;   // columns [left, right) contain all pixels
  std::uint8_t strips = 0;           // 0: too large for a stamp
  std::uint8_t pairs = 0;
  std::uint8_t most = 0;             // the greatest weight
  std::uint8_t narrow = 0;           // 1: no row has more than kNarrow pixels
  std::uint8_t column[kPairs] = {};  // from `left` to each pair's first pixel

  /// Weights 0..255 on the scale of Footprint, in the layout drawn above.
  std::uint8_t weights[kBlocks * kBlock] = {};

  bool usable() const { return strips != 0; }
};

struct ImageLevel;

/// Holds the weights of one small image: of one tile or a mixture of two, in one size and direction, at one of 16
/// sub-pixel positions. They depend only on `levels`, the key and `part`.
///
/// A strip has 8 pixels of each row: cover has one number for each, light three:
///
///   strip 0: row 0 (8 pixels), row 1, ... row kRows-1; strip 1: ...
struct alignas(64) ImageStamp {
  static constexpr int kRows = 16, kStrips = 2, kStrip = 8;
  static constexpr int kPixels = kRows * kStrips * kStrip;

  const ImageLevel* levels = nullptr;  // of the tile; null: no stamp
  std::uint32_t key = 0;
  int part = 0;  // weight of the next tile, 1/256
  std::int8_t first = 0, left = 0;      // first row and column, relative to the pixel of the image's middle
  std::uint8_t rows = 0, strips = 0;    // 0: nothing visible
  float share = 0;                      // light of a weight of 1, per square pixel of the image
  float most = 0;                       // greatest light of a weight of 1
  std::uint8_t covered[kRows * kStrips];
  union {
    struct {
      std::uint16_t cover[kPixels], light[3 * kPixels];
    } weights;
    std::uint32_t surface[kPixels];
  };
};

/// Widest images, px, that are drawn from stamps, which have sizes in steps of 1/8 px and 256 directions.
inline constexpr float kStampedImage = 8;
inline constexpr int kImageStampBits = 12;
inline constexpr int kImageStamps = 1 << kImageStampBits;

/// Scales weights by 2^kStampShift before a partly hidden streak is multiplied by its visible part; the tint is scaled
/// down to match.
inline constexpr int kStampShift = 6;

/// Number of stamps per painter (14 MB), allocated when it first draws such streaks.
inline constexpr int kStampBits = 14;
inline constexpr int kStamps = 1 << kStampBits;

/// Sums of weights at a tile's pixels: one number per pixel instead of three. The light of a streak is weight times
/// colour, without rounding, so adding weights first and multiplying once gives the same bits.
///
/// Weights are added in blocks of two rows (see Stamp). Two planes hold pairs of rows, so that a block is contiguous
/// whether it begins in an even or an odd row; in a pair, the numbers of both rows alternate:
///
///   even plane:  rows 0|1, 2|3, ...     odd plane:  rows -1|0, 1|2, ...
///   pair a|b:    a0 b0 a1 b1 a2 b2 ...
struct Cover {
  static constexpr int kPairStride = 2 * kPixelStride;
  /// Offset from the even plane to the odd plane.
  static constexpr int kOddRows = (kTile / 2 + 2) * kPairStride;
  static constexpr int kFirst = kPairStride;
  static constexpr std::size_t kNumbers = 2 * kOddRows + kFirst;

  std::uint16_t* weights = nullptr;  // first pair's first pixel; all 0 in the tile's columns after it was shown
  std::uint32_t* sums = nullptr;     // 32-bit overflow of `weights`, rows of kPixelStride numbers
  std::uint32_t most = 0;            // bound on the greatest of `weights`
  bool has_sums = false;             // `sums` is in use; otherwise all 0
  std::uint32_t color = 0;           // colour and alpha, as in a record
  std::uint16_t light = 0;           // factor on alpha, as WideRecord::light
  std::uint32_t records = 0;         // bound on the number of records in it
  bool saturating = false;           // sums of light may overflow and must saturate

  /// Greatest number of records: the light of more would not fit into 32 bits.
  static constexpr std::uint32_t kMost = 4096;
};

}  // namespace motes::image
