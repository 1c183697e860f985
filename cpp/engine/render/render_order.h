// Orders the tiles of a picture and the ranks that get them, so ranks draw mostly their own particles, whose records
// need not be sent.
#pragma once

#include <cstdint>
#include <vector>

#include "image/grid.h"
#include "image/scene.h"
#include "image/slots.h"
#include "roles/cast.h"

namespace motes::engine {

struct Deal {
  image::TileOrder order = image::TileOrder::rows;
  std::vector<int> ranks;  // each rank once, in the order of their stretches of tiles
};

/// Returns the order of tiles and ranks for domains that are slices along `axis` (0..2). If the axis runs horizontally
/// on the screen, tiles are dealt out column by column, otherwise row by row; calculators in the order of their slices
/// on the screen, with ranks without particles in between.
Deal deal_along(int axis, const image::View& view, const roles::Cast& cast, int ranks);

}  // namespace motes::engine
