// Light as surfaces, see NearestSurface. Compiled once for each instruction set.
#pragma once

#include "image/tile_planes.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Uints bright_surface(Floats3 light, Floats most) {
  const Floats held = min(most, all(static_cast<float>(1 << image::kMostBright)));
  const Ints exponent = min_ints((Ints)(((Uints)held + 0x7fffffu) >> 23) - 127, all_ints(image::kMostBright));
  const Floats part = (Floats)((Uints)(127 - exponent) << 23) * (held / most);
  const auto number = [&](Floats of, float greatest) { return (Uints)to_ints(of * part * greatest + 0.5f); };
  return (Uints)exponent << image::kBrightExponent | number(light.x, 127) << image::kBrightRed |
         number(light.y, 127) << image::kBrightGreen | number(light.z, 63);
}

/// Returns surfaces of this light, which is not negative. The shade is that of the brightest channel, rounded up, so
/// that faint light is as precise as bright light.
MOTES_INLINE Uints surface_of(Floats3 light) {
  const Floats most = max(max(light.x, light.y), light.z);
  const Ints shade = min_ints(max_ints(to_ints(min(most, all(1.0f)) * 255.0f + 0.999f), all_ints(1)), all_ints(255));
  const Floats per = (255.0f * 255.0f) / to_floats(shade);
  const auto number = [&](Floats of) { return (Uints)to_ints(min(of * per + 0.5f, all(255.0f))); };
  const Uints plain = (Uints)shade << 24 | number(light.z) << 16 | number(light.y) << 8 | number(light.x);
  const Mask bright = most > 1.0f;
  return any(bright) ? (Uints)select(bright, (Ints)bright_surface(light, max(most, all(1.0f))), (Ints)plain) : plain;
}

}  // namespace motes::MOTES_ISA
