// Pictures that are kept beside the frame: depth, alpha, velocity.
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

/// The layers that a view asks for, of a whole picture. depth: m to the nearest solid or opaque particle, along the
/// direction of view; infinite where there is none. alpha: the part of the light from behind that is held back, 0..1.
/// velocity: m/s of the nearest opaque particle, x, y, z; 0 where something else is nearer.
class Layers {
 public:
  /// Makes room for a picture of this view; its values are undefined.
  void begin(const View& view);

  /// Keeps the layers of the tile that `painter` has painted with these pieces. The painter's light is overwritten.
  void keep(TilePainter& painter, std::span<const Piece> pieces, const Area& area);

  /// The same where another rank puts the picture together: appends the layers of a tile to a message, and there takes
  /// them from it.
  static void send(const View& view, TilePainter& painter, std::span<const Piece> pieces, const Area& area,
                   base::Bytes& out);
  void take(const Area& area, base::Reader& in);

  /// Keeps the layers of a tile in which nothing is seen.
  void keep_blank(const Area& area);

  /// One layer: height * width values, rows from top to bottom; three for each pixel of velocity. Throws
  /// std::logic_error where the last view did not ask for it.
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
