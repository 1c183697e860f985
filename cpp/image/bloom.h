// Bloom: a part of the light spreads around what is bright, as in a lens or an eye.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "image/bloom_lanes.h"
#include "threads/pool.h"

namespace motes::image {

/// Works on a whole picture's sums of light, in integers only, so all builds give the same bits. The glow is a sum of
/// three Gauss curves whose radii are parts of the picture's height: it looks the same at any resolution. In total the
/// light stays the same: what would leave the picture is reflected at its edges.
class Bloom {
 public:
  explicit Bloom(const BloomLanes& lanes = bloom_lanes()) : lanes_(&lanes) {}

  /// Replaces `part`, 0..1, of the light of each pixel by light from around it. `light` has height * width * 3 sums,
  /// rows from top to bottom; throws std::invalid_argument where it has not, or where `part` is not in 0..1.
  void spread(std::span<std::uint32_t> light, int width, int height, float part,
              threads::Pool& pool = threads::alone());

 private:
  // One direction of a level: `fine` pixels, or cells of the next finer level, are divided evenly into `cells`.
  struct Axis {
    int fine = 1, cells = 1;
    Taps taps;

    // Cell c averages the finer ones from first[c], with weights[begin[c]] .. weights[begin[c + 1] - 1].
    std::vector<int> first;
    std::vector<std::size_t> begin;
    std::vector<std::uint32_t> weights;

    // Between two cells' centres: the cell before finer one i (-1: before all), and how far i is from there to the
    // next.
    int before(int i) const;
    std::uint64_t beyond(int i) const;
  };

  // The picture in cells: averages, with bits after the point.
  struct Level {
    Axis across, down;
    std::uint32_t share = 0;  // of the light, in 2^-16
    std::vector<std::uint64_t> light;

    std::size_t lanes() const { return static_cast<std::size_t>(across.cells) * 3; }
    std::uint64_t* row(int y) { return light.data() + static_cast<std::size_t>(y) * lanes(); }
  };

  void plan(int width, int height, float part);
  static Axis divided(int pixels, int fine, double cell, double radius, double& widened);
  // Rows that a worker works on.
  struct Rows {
    std::vector<std::uint64_t> sums, near, far, glow, step;
  };

  void average(const std::uint32_t* light, Level& level, threads::Pool& pool);
  void average(Level& fine, Level& coarse);
  static void average_row(const std::vector<std::uint64_t>& sums, Level& level, int row, int shift);
  void blur(Level& level);
  static void widen(Level& level, int row, std::vector<std::uint64_t>& to);
  template <class Mix>
  void enlarge(Level& level, threads::Pool& pool, const Mix& mix);
  template <class Mix>
  static void enlarge_part(Level& level, int first, int last, Rows& rows, const Mix& mix);

  const BloomLanes* lanes_;
  int width_ = 0, height_ = 0;
  float part_ = -1;
  std::array<Level, 3> levels_;
  std::vector<std::uint64_t> blurred_, padded_;  // working memory
  std::vector<Rows> rows_;                       // one per worker
};

}  // namespace motes::image
