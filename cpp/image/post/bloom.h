// Bloom: a part of the light spreads around bright places, as in a lens or an eye.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/post/bloom_cells.h"
#include "image/post/bloom_plan.h"
#include "image/post/bloom_tiles.h"
#include "threads/pool.h"

namespace motes::image {

/// Computes the glow of a whole picture from averages of its tiles' light. BloomTiles provides the averages, and mixes
/// the glow into the tiles. All numbers are integers, so all builds give the same bits. The glow is a sum of three
/// Gaussians whose radii are fractions of the picture's height, so it looks the same at any resolution. The total light
/// stays the same: light that would leave the picture is reflected at its edges.
class Bloom {
 public:
  explicit Bloom(const BloomLanes& kernels = bloom_lanes()) : kernels_(&kernels) {}

  /// Starts without light. The plan must not change until spread() has returned.
  void begin(const BloomPlan& plan);

  /// Adds a tile's averages: area.lanes() 64-bit integers, which must not change until spread() has returned. Throws
  /// std::invalid_argument if the area is not in the picture, or there are more or fewer averages.
  void add(const CellArea& area, std::span<const std::byte> averages);

  /// Adds the averages of all tiles of this rank.
  void add(const BloomTiles& tiles);

  /// Spreads the light that was added.
  void spread(threads::Pool& pool = threads::alone());

  /// Returns the glow of the picture's finest cells.
  BloomCells cells() const { return levels_[0].cells(); }

 private:
  struct Part {
    CellArea area;
    const std::byte* averages;
  };
  // The picture in cells: averages with fractional bits.
  struct Level {
    const BloomPlan::Level* plan = nullptr;
    std::vector<std::uint64_t> light;

    int rows() const { return plan->down.cells; }
    std::size_t lanes() const { return static_cast<std::size_t>(plan->across.cells) * 3; }
    std::uint64_t* row(int y) { return light.data() + static_cast<std::size_t>(y) * lanes(); }
    BloomCells cells() const { return {{0, 0, plan->across.cells, plan->down.cells}, light.data(), lanes()}; }
  };
  // A thread's working memory.
  struct Rows {
    std::vector<std::uint64_t> sums;
    GlowRows glow;
  };

  void add_up(threads::Pool& pool);
  void average(Level& fine, Level& coarse, threads::Pool& pool);
  void blur(Level& level, threads::Pool& pool);
  void blur_row(Level& level, int y, std::vector<std::uint64_t>& padded);
  void enlarge_level(Level& coarse, Level& fine, threads::Pool& pool);

  const BloomLanes* kernels_;
  std::vector<Part> parts_;
  std::array<Level, 3> levels_;
  std::vector<std::uint64_t> blurred_;  // working memory
  std::vector<Rows> rows_;              // one per worker
};

}  // namespace motes::image
