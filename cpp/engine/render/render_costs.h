// Costs of drawing, used to plan pictures; they change no pixel. Measured by `python -m motes bench costs` on one core
// of an AMD EPYC with AVX-512 and, for messages, between two ranks on one machine. Only ratios matter, and these are
// similar on other processors.
#pragma once

#include "image/exposures.h"
#include "image/scene.h"

namespace motes::engine::render_costs {

// Nanoseconds.
inline constexpr double kProject = 1.8;  // per particle: project, cull, sort by tile
inline constexpr double kPixel = 1.1;  // per pixel of a tile: clear, tone-map
inline constexpr double kBloomPixel = 3.1;  // extra per pixel with bloom: keep, average, add glow
inline constexpr double kSpreadPixel = 0.9;  // extra per pixel of the picture, on the image generator: spread averages
inline constexpr double kExposedPixel = 900;  // extra per pixel, if rays are cast for each exposure
inline constexpr double kExposed = 10;  // factor on an opaque record that has exposures
inline constexpr double kByte = 0.17;  // per byte of a message, at each end: pack, send, receive
inline constexpr double kMessage = 2600;  // per message, at each end
inline constexpr double kPartialPixel = 0.54;  // per pixel of a partial tile: clear, pack; again to merge

// Bytes per pixel.
inline constexpr double kLightBytes = 12;  // partial tile with additive particles
inline constexpr double kSurfaceBytes = 8;  // partial tile with opaque particles
inline constexpr double kShownBytes = 3;  // finished tile
inline constexpr double kGlowBytes = 3.5;  // averages to the image generator, and glow back

/// Returns the cost of drawing a record, ns.
inline double record(const image::Sprite& sprite, const image::View& view) {
  const bool fixed = !sprite.is(image::Sprite::Kind::point) && sprite.pixels >= 1;
  const double pixels = sprite.is(image::Sprite::Kind::point) ? 2
                        : sprite.of_height > 0                ? static_cast<double>(sprite.of_height) * view.height
                        : fixed                               ? sprite.pixels
                                                              : 8;  // sizes in metres: unknown
  double cost = 2.6 + 0.12 * pixels * pixels;
  if (!view.objects.empty()) cost *= 1.2;
  if (sprite.blend == image::Sprite::Blend::alpha) cost *= 2.5;
  if (view.shutter > 0) cost *= 2;
  if (sprite.blend == image::Sprite::Blend::opaque && image::has_exposures(view)) cost *= kExposed;
  return cost;
}

/// Returns the cost of a pixel, ns.
inline double pixel(const image::View& view) {
  return kPixel + (view.bloom > 0 ? kBloomPixel : 0) + (image::scenery_blurs(view) ? kExposedPixel : 0);
}

/// Returns the cost of a pixel relative to one without bloom.
inline double passes(const image::View& view) { return pixel(view) / kPixel; }

/// Returns the cost of spreading bloom per pixel, relative to a pixel without bloom.
constexpr double spreading(const image::View& view) { return view.bloom > 0 ? kSpreadPixel / kPixel : 0; }

/// Returns the estimated bytes of a record in a message, used before any has been sent.
constexpr double record_bytes(const image::View& view) { return view.objects.empty() ? 8 : 12; }

}  // namespace motes::engine::render_costs
