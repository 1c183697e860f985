// The pixels that one particle lights, and how much.
#pragma once

#include <cstdint>
#include <vector>

#include "image/scene.h"

namespace motes::image {

/// A sprite's weights, 0..254, for each sub-pixel position ("phase") of its centre. A particle at x (pixels from the
/// left edge) lights columns floor(x + 1/2 - size/2) .. + size-1, and rows likewise; the fraction that the floor drops
/// is the phase. All phases of a sprite have the same sum, so a moving particle does not flicker.
struct Footprint {
  int size = 0;        // pixels per side
  int phase_bits = 0;  // 2^phase_bits phases along each axis
  int row_bytes = 0;   // one row: `size` weights, each three times (red, green, blue), then zeros

  /// Row r of phase (px, py) starts at ((py << phase_bits | px) * size + r) * row_bytes.
  std::vector<std::uint8_t> weights;
};

/// Pixels per side. A disc of one pixel is drawn as a point: its light is
/// shared by the 2x2 nearest pixels. `height`: of the picture.
int footprint_size(const Sprite& sprite, int height);

/// Built at first use, valid until the program ends. Of a sprite with a size in
/// pixels, or a point.
const Footprint& footprint(const Sprite& sprite);

/// Scales weights, of up to 1, to that sum, none above 254: what would be goes to the others.
void scale_to(std::vector<double>& weights, double total);

/// Of a disc of any diameter up to kMaxFootprint pixels.
Footprint footprint_of(float diameter);

} // namespace motes::image
