// Bloom: a part of the light spreads around what is bright, as in a lens or an eye.
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

/// The glow of a whole picture, from averages of its tiles' light to what spreads over them: BloomTiles makes those and
/// takes this. In integers only, so all builds give the same bits. It is a sum of three Gauss curves whose radii are
/// parts of the picture's height: it looks the same at any resolution. In total the light stays the same: what would
/// leave the picture is reflected at its edges.
class Bloom {
 public:
  explicit Bloom(const BloomLanes& kernels = bloom_lanes()) : kernels_(&kernels) {}

  /// Starts without light. The plan must not change until spread() has returned.
  void begin(const BloomPlan& plan);

  /// Takes what a tile adds to its cells: area.lanes() integers of 64 bits, which must not change until spread() has
  /// returned. Throws std::invalid_argument where the area is not one of the picture's, or there are not as many.
  void add(const CellArea& area, std::span<const std::byte> averages);

  /// The same for all tiles of this rank.
  void add(const BloomTiles& tiles);

  /// Spreads what was added.
  void spread(threads::Pool& pool = threads::alone());

  /// What glows in a picture's finest cells.
  BloomCells cells() const { return levels_[0].cells(); }

 private:
  struct Part {
    CellArea area;
    const std::byte* averages;
  };
  // The picture in cells: averages, with bits after the point.
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
