// A space-filling curve: it visits all cells of a room one after another. Where domains are stretches of the curve, the
// place of a particle's cell along it replaces the position.
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

/// Boxes around everything that belongs to a domain, and perhaps more. The first `whole` boxes belong to it entirely.
struct BoxCover {
  std::vector<Box> boxes;
  std::size_t whole = 0;
  Box around;  // around all boxes
};

/// A curve through 256 cells along each axis of a room. Positions outside of the room count as in the nearest cell.
class Curve {
 public:
  static constexpr int kLevels = 8;
  static constexpr std::uint32_t kAlong = 1u << kLevels;  // cells along an axis
  static constexpr std::uint32_t kCells = 1u << (3 * kLevels);  // as many as float32 can distinguish between 0 and 1
  /// Blocks are the cells of a tree with half as many levels. Each is a stretch of the curve.
  static constexpr int kBlockLevels = kLevels / 2;
  static constexpr std::uint32_t kBlocks = 1u << (3 * kBlockLevels);
  static constexpr std::uint32_t kInBlock = kCells / kBlocks;  // cells

  /// `axis`: kMorton or kHilbert. Throws std::invalid_argument if the room has no extent along an axis in float32.
  Curve(int axis, const Room& room);

  int axis() const { return axis_; }
  /// Returns the largest distance of an end of the room from the origin, m.
  float farthest_end() const;

  /// The numbers of a cell along x, y and z, 0..255.
  using Cell = std::array<std::uint32_t, 3>;
  Cell cell_of(float x, float y, float z) const { return {index(0, x), index(1, y), index(2, z)}; }
  /// Returns the number of a cell along the curve.
  std::uint32_t number_of(const Cell& cell) const;
  /// Returns the place of a cell along the curve, 0 <= s < 1.
  static float place_of(std::uint32_t number) { return static_cast<float>(number) * (1.0f / kCells); }
  /// Writes the places of particles first .. last - 1 along the curve; NaN if a coordinate is NaN.
  void places_of(const Places& places, std::size_t first, std::size_t last, float* along) const;

  /// Returns the number of a cell's block along the curve.
  std::uint32_t block_of(const Cell& cell) const {
    constexpr int kFiner = kLevels - kBlockLevels;
    return blocks_[cell[0] >> kFiner | cell[1] >> kFiner << kBlockLevels | cell[2] >> kFiner << 2 * kBlockLevels];
  }

  /// Returns the number of the first cell at or behind a cut, 0..kCells.
  static std::uint32_t first_behind(float cut);
  /// Returns boxes around cells first .. last - 1 along the curve; if there are none, around the next cell.
  BoxCover cover(std::uint32_t first, std::uint32_t last) const;

  bool operator==(const Curve& other) const {
    return axis_ == other.axis_ && low_ == other.low_ && high_ == other.high_;
  }

 private:
  // Returns the number of a coordinate's cell along an axis. Rounding may move faces between cells, but every lookup of
  // a position uses this rule.
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
  std::vector<std::uint16_t> blocks_;  // their numbers along the curve, by place in the room
};

}  // namespace motes::domains
