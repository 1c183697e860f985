// A space-filling curve: it visits all cells of a room one after another, and the place of a particle's cell along it
// stands for its position where domains are stretches of the curve.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "domains/axes.h"
#include "domains/space.h"
#include "domains/turns.h"

namespace motes::domains {

/// Boxes that hold all that belongs to a domain, and perhaps more. All that lies in one of the first `whole` belongs to
/// it.
struct BoxCover {
  std::vector<Box> boxes;
  std::size_t whole = 0;
  Box around;  // all boxes
};

/// 256 cells along each axis of a room. What lies outside of the room counts as in the nearest cell.
class Curve {
 public:
  static constexpr int kLevels = 8;
  static constexpr std::uint32_t kAlong = 1u << kLevels;        // cells along an axis
  static constexpr std::uint32_t kCells = 1u << (3 * kLevels);  // as many as a float32 tells apart between 0 and 1
  /// Blocks are cells of half as many levels. Each is a stretch of the curve.
  static constexpr int kBlockLevels = kLevels / 2;
  static constexpr std::uint32_t kBlocks = 1u << (3 * kBlockLevels);
  static constexpr std::uint32_t kInBlock = kCells / kBlocks;  // cells

  /// `axis`: kMorton or kHilbert. Throws std::invalid_argument where the room has no extent along an axis, as float32s.
  Curve(int axis, const Room& room);

  int axis() const { return axis_; }
  /// The largest distance of an end of the room from the origin, m.
  float farthest_end() const;

  /// The numbers of particles' cells along x, y and z, 0..255.
  using Cell = std::array<std::uint32_t, 3>;
  Cell cell_of(float x, float y, float z) const { return {index(0, x), index(1, y), index(2, z)}; }
  /// The number of a cell along the curve.
  std::uint32_t number_of(const Cell& cell) const;
  /// Where a cell is along the curve, 0 <= s < 1.
  static float place_of(std::uint32_t number) { return static_cast<float>(number) * (1.0f / kCells); }
  /// Of particles number `first` to `last` - 1; NaN where a coordinate is.
  void places_of(const Places& places, std::size_t first, std::size_t last, float* along) const;

  /// The number of a cell's block along the curve.
  std::uint32_t block_of(const Cell& cell) const {
    constexpr int kFiner = kLevels - kBlockLevels;
    return blocks_[cell[0] >> kFiner | cell[1] >> kFiner << kBlockLevels | cell[2] >> kFiner << 2 * kBlockLevels];
  }

  /// The number of the first cell that lies at or behind a cut, 0..kCells.
  static std::uint32_t first_behind(float cut);
  /// Boxes around cells number first .. last - 1 along the curve; around the next one where there are none.
  BoxCover cover(std::uint32_t first, std::uint32_t last) const;

  bool operator==(const Curve& other) const {
    return axis_ == other.axis_ && low_ == other.low_ && high_ == other.high_;
  }

 private:
  // Rounding may move faces between cells, but all that look at a position use this rule.
  std::uint32_t index(std::size_t axis, float x) const {
    const float at = (x - low_[axis]) * scale_[axis];
    const float most = static_cast<float>(kAlong - 1);
    const float above = at > 0 ? at : 0.0f;  // NaN too
    return static_cast<std::uint32_t>(above < most ? above : most);
  }
  float face(std::size_t axis, std::uint32_t cell) const;
  std::uint32_t number_of(const Cell& cell, int levels) const;
  friend class Covering;

  int axis_;
  std::span<const Turns> turns_;
  std::array<float, 3> low_, high_, scale_;
  std::array<std::vector<float>, 3> faces_;  // along each axis, the lower ends of cells; outer ones are at infinity
  std::vector<std::uint16_t> blocks_;  // by their place in the room: their numbers along the curve
};

}  // namespace motes::domains
