// The instants and the points on the lens at which a picture shows what is opaque: solids and opaque particles. Each
// pixel is the mean of kExposures sharp pictures, as integers, so its bits do not depend on who draws what.
//
// Pixels of 2x2 have different instants (phases), each in the same sixteenth of the exposure, so that the ends of a
// streak blend into a fine pattern instead of steps.
#pragma once

#include <cstdint>

#include "image/camera.h"
#include "image/scene.h"

namespace motes::image {

struct Exposure {
  float time;              // -0.5: the shutter opens; 0.5: it closes
  float lens_x, lens_y;    // on a lens whose radius is 1, right and down
  float pixel_x, pixel_y;  // from the pixel's middle, px
};

inline constexpr int kExposures = 16;
/// The phase of the pixel in column x and row y is 2 (y % 2) + x % 2.
inline constexpr int kPhases = 4;

struct Exposures {
  Exposure of[kExposures][kPhases];
};

/// Returns the exposures of all pictures.
const Exposures& exposures();

/// Returns whether what is opaque has exposures: the shutter is open for a time, or the lens has a width.
inline bool has_exposures(const View& view) { return view.shutter > 0 || view.camera.aperture > 0; }

/// Returns whether solids, or the sky, look different in different exposures.
bool scenery_blurs(const View& view);

/// Returns the sharp view of an exposure: the camera at a point on its lens, and objects where they are then. A point
/// at (x, y) px of the picture appears at (x, y) - `shift` there.
struct ExposedView {
  View view;
  float shift_x, shift_y;  // px
};
ExposedView exposed_view(const View& view, const Exposure& exposure);

}  // namespace motes::image
