// Orders the tiles of a picture and the ranks that get them, so that ranks draw where their own particles are: those
// records need not be sent.
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
  std::vector<int> ranks;  // each once, in the order of their stretches of tiles
};

/// Domains are slices along `axis` (0..2). Where it runs across the screen, tiles are dealt out column by column, else
/// row by row; calculators follow in the order in which their slices are seen, the ranks without particles in between.
Deal deal_along(int axis, const image::View& view, const roles::Cast& cast, int ranks);

}  // namespace motes::engine
