// The view, scenery and tone curve that all tiles of a frame share.
#pragma once

#include <cstdint>
#include <vector>

#include "image/grid.h"
#include "image/raycast/scenery.h"
#include "image/scene.h"

namespace motes::image {

/// A view prepared for painting. It does not change while tiles are painted, so several tile painters may share it.
/// Usage: prepare for each frame, then render the tiles that this rank paints.
class PreparedScene {
 public:
  /// Prepares a view. Throws std::invalid_argument if it is not valid. `shadows`: see Scenery::prepare.
  void prepare(const View& view, std::size_t workers = 1, const ShadowGrids* shadows = nullptr);

  /// Renders the scenery of a tile, unless it is rendered already; different workers may render at the same time.
  void render(int tile, std::size_t worker = 0) { scenery_.render(tile, worker); }
  void render_all(threads::Pool& pool = threads::alone()) { scenery_.render_all(pool); }

  /// Changes whenever tiles without particles may look different.
  std::uint64_t version() const { return version_; }

  const View& view() const { return view_; }
  const Grid& grid() const { return grid_; }
  const Scenery& scenery() const { return scenery_; }
  /// See tone_table().
  const std::vector<std::uint16_t>& tone() const { return tone_; }
  bool prepared() const { return prepared_; }

 private:
  bool prepared_ = false;
  std::uint64_t version_ = 0;
  View view_;
  Grid grid_;
  Scenery scenery_;
  std::vector<std::uint16_t> tone_;
};

}  // namespace motes::image
