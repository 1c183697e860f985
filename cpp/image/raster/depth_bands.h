// The depths around the surfaces of a tile at which it is not clear at once whether a surface hides a particle.
#pragma once

#include <cstdint>

#include "image/layout.h"

namespace motes::image {

/// One pixel's: a record whose centre is nearest to this pixel is in front of the surface if its depth is below `low`,
/// and deep enough to be hidden from `high` on, m.
struct DepthBand {
  float low, high;
};

/// How records find their bands. A centre's column is (2 * position + first_column) >> shift, within 0..last_column.
struct BandSearch {
  const DepthBand* bands;  // kTile rows of kTile
  Layout layout;
  RecordForm form;
  int record_bytes;
  int shift, first_column, first_row;
  int last_column, last_row;
  int most_size;  // a larger record (see WideRecord::size) has no band: it is always found
};

}  // namespace motes::image
