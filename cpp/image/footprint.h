// Weights of the pixels that a particle lights.
#pragma once

#include <cstdint>
#include <vector>

#include "image/scene.h"

namespace motes::image {

/// A sprite's weights, 0..254, for each sub-pixel position ("phase") of its centre. A particle at x (pixels from the
/// left edge) lights columns floor(x + 1/2 - size/2) .. + size-1, and y gives the rows in the same way; the fraction
/// that the floor drops is the phase. All phases of a sprite have the same sum, so a moving particle does not flicker.
struct Footprint {
  int size = 0;        // pixels per side
  int phase_bits = 0;  // 2^phase_bits phases along each axis
  int row_bytes = 0;   // bytes per row: `size` weights, each three times (red, green, blue), then zeros

  /// Row r of phase (px, py) starts at ((py << phase_bits | px) * size + r) * row_bytes.
  std::vector<std::uint8_t> weights;
};

/// Returns the side of a sprite's footprint, px. `height`: of the picture, px.
int footprint_size(const Sprite& sprite, int height);

/// Returns the footprint of a point, or of a disc whose size is given in pixels. It is built at first use and valid
/// until the program ends.
const Footprint& footprint(const Sprite& sprite);

/// Scales weights of up to 1 to the sum `total`, with none above 254; the excess goes to the others.
void scale_to(std::vector<double>& weights, double total);

/// Builds the footprint of a disc of any diameter up to kMaxFootprint px.
Footprint footprint_of(float diameter);

} // namespace motes::image
