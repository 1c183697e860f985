// Plain structs that ranks exchange about the work on a frame's picture.
#pragma once

#include <cstdint>
#include <vector>

#include "image/scene.h"
#include "image/slots.h"

namespace motes::engine {

/// Consecutive tile slots that a rank drew.
struct DrawnTiles {
  std::uint32_t first = 0;
  std::vector<std::uint32_t> counts;  // records in each
  std::int32_t rank = 0;
  float seconds = 0;  // 0: not measured
};

template <class Visitor>
constexpr void fields(Visitor& visit, DrawnTiles& tiles) {
  visit(tiles.first, tiles.counts, tiles.rank, tiles.seconds);
}

/// Where a system's particles are relative to the picture: behind the camera, outside its view, or in view. Several
/// values are combined by maximum.
enum class Sighted : std::uint8_t { unknown, behind, beside, inside };

/// A rank's work on a frame's picture.
struct Drawing {
  std::int32_t width = 0, height = 0;  // pixels; 0: the frame had no picture
  image::View::Path path = image::View::Path::gather;
  std::uint64_t records = 0;  // records of its own particles
  std::uint64_t record_bytes = 0;  // bytes of all records
  std::uint64_t sent = 0;     // records sent to other ranks, as such or in partial tiles
  std::uint64_t bytes = 0;    // bytes sent to other ranks
  std::uint32_t active = 0;   // number of tiles that its own particles touch
  image::TileOrder order = image::TileOrder::rows;
  std::uint32_t first = 0;            // the first slot that it drew
  std::vector<std::uint32_t> counts;  // records in each slot that it drew
  double draw_s = 0;                  // seconds of work to draw them; 0: not measured
  double assemble_s = 0;              // seconds to assemble other ranks' tiles
  std::vector<Sighted> sighted;       // on a calculator: one per system
};

/// Work on a picture of all ranks in a subtree.
struct Drawings {
  std::int32_t width = 0, height = 0;
  image::View::Path path = image::View::Path::gather;
  image::TileOrder order = image::TileOrder::rows;
  std::uint64_t records = 0;
  std::uint64_t record_bytes = 0;
  std::uint64_t sent = 0;
  std::uint64_t bytes = 0;
  double assemble_s = 0;
  std::vector<std::uint32_t> active;  // one per calculator
  std::vector<DrawnTiles> tiles;
  std::vector<Sighted> sighted;  // one per system
};

template <class Visitor>
constexpr void fields(Visitor& visit, Drawings& drawings) {
  visit(drawings.width, drawings.height, drawings.path, drawings.order, drawings.records, drawings.record_bytes,
        drawings.sent, drawings.bytes, drawings.assemble_s, drawings.active, drawings.tiles, drawings.sighted);
}

Drawings drawings_of(Drawing drawing, int rank, bool calculates);

}  // namespace motes::engine
