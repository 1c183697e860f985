// point: no size; it lights the 2x2 pixels around it, and an opaque one covers a single pixel.
#pragma once

#include "image/raster/kind_disc.h"

namespace motes::MOTES_ISA {

/// A moving point: a disc of two pixels.
struct Point : Disc {
  MOTES_INLINE Point(const image::WideSplat& task, const WideSprite& sprite) : Disc(task, sprite) {}

  /// Returns the front of the smallest disc that covers at least one pixel at any position.
  // NOLINTNEXTLINE(bugprone-derived-method-shadowing-base-method): kernels know the kind when they are compiled
  MOTES_INLINE Front front(Floats x, Floats y) const {
    const Floats along = x * s.along_x + y * s.along_y, across = y * s.along_x - x * s.along_y;
    const Floats rest = along - clamp(along, -s.half, s.half);
    return {rest * rest + across * across <= 0.5f, surface_of(all_uints(s.color), all(1.0f)), Floats{}};
  }
};

}  // namespace motes::MOTES_ISA
