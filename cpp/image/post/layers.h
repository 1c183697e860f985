// Pictures kept in addition to the frame: depth, alpha, velocity.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "image/grid.h"
#include "image/raster/pieces.h"
#include "image/raster/tile_painter.h"
#include "image/scene.h"

namespace motes::image {

/// The layers that a view requests, for a whole picture. depth: view depth of the nearest solid or opaque particle, m;
/// infinite where there is none. alpha: the part of the light from behind that is blocked, 0..1. velocity: that of the
/// nearest opaque particle (x, y, z), m/s; 0 where something else is nearer.
class Layers {
 public:
  /// Makes room for a picture of this view; its values are undefined.
  void begin(const View& view);

  /// Keeps the layers of the tile that `painter` has painted with these pieces. The painter's light is overwritten.
  void keep(TilePainter& painter, std::span<const Piece> pieces, const Area& area);

  /// If another rank assembles the picture: append the layers of a tile to a message, and there take them from it.
  static void send(const View& view, TilePainter& painter, std::span<const Piece> pieces, const Area& area,
                   base::Bytes& out);
  void take(const Area& area, base::Reader& in);

  /// Puts a surface that is not a particle's in front of everything else at a pixel; `depth`: m.
  void cover(int x, int y, float depth);

  /// Keeps the layers of a tile in which nothing is visible.
  void keep_blank(const Area& area);

  /// Returns a layer: height * width values, rows from top to bottom; velocity has three per pixel. Throws
  /// std::logic_error if the last view did not request it.
  const std::vector<float>& layer(std::uint8_t bit) const;

 private:
  struct Plane {
    std::uint8_t bit;
    std::size_t values;  // per pixel
    std::vector<float> all;
  };

  float* at(Plane& plane, const Area& area) const;

  std::size_t width_ = 0;
  std::array<Plane, 3> planes_{{{kDepthLayer, 1, {}}, {kAlphaLayer, 1, {}}, {kVelocityLayer, 3, {}}}};
};

}  // namespace motes::image
