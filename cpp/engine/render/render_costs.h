// Costs of drawing, in seconds, from which the plan of a picture is made; they change no pixel. Measured by `python -m
// motes bench costs` on one core of an AMD EPYC with AVX-512 and, for messages, between two ranks on one machine. Only
// ratios matter, and those are similar on other processors.
#pragma once

#include "image/scene.h"

namespace motes::engine::render_costs {

// Nanoseconds.
inline constexpr double kProject = 1.8;  // a particle: projected, culled, sorted by tile
inline constexpr double kPixel = 1.1;  // a pixel of a tile: started, tone-mapped
inline constexpr double kBloomPixel = 3.1;  // more, where light spreads: kept, averaged, mixed with what glows there
inline constexpr double kSpreadPixel = 0.9;  // on the image generator alone: averages of all tiles become their glow
inline constexpr double kByte = 0.17;  // a byte of a message at each of its ends: packed, sent, received
inline constexpr double kMessage = 2600;  // a message at each of its ends
inline constexpr double kPartialPixel = 0.54;  // a pixel of a partial tile: cleared, packed; and the same to add it

// Bytes of a pixel.
inline constexpr double kLightBytes = 12;  // bytes per pixel of a partial tile with additive particles
inline constexpr double kSurfaceBytes = 8;  // bytes per pixel of a partial tile with opaque particles
inline constexpr double kShownBytes = 3;  // bytes per pixel of a finished tile
inline constexpr double kGlowBytes = 3.5;  // bytes per pixel of averages and glow, to the image generator and back

/// Returns the cost of drawing a record.
constexpr double record(const image::Sprite& sprite, const image::View& view) {
  const bool fixed = sprite.kind != image::Sprite::Kind::point && sprite.pixels >= 1;
  const double pixels = sprite.kind == image::Sprite::Kind::point ? 2
                        : sprite.of_height > 0                    ? static_cast<double>(sprite.of_height) * view.height
                        : fixed                                   ? sprite.pixels
                                                                  : 8;  // sizes in metres: unknown
  double cost = 2.6 + 0.12 * pixels * pixels;
  if (!view.objects.empty()) cost *= 1.2;
  if (sprite.blend == image::Sprite::Blend::alpha) cost *= 2.5;
  if (view.shutter > 0) cost *= 2;
  return cost;
}

/// Returns the cost of a pixel.
constexpr double pixel(const image::View& view) { return kPixel + (view.bloom > 0 ? kBloomPixel : 0); }

/// Returns the cost of a pixel relative to one without bloom.
constexpr double passes(const image::View& view) { return pixel(view) / kPixel; }

/// Spreading, likewise.
constexpr double spreading(const image::View& view) { return view.bloom > 0 ? kSpreadPixel / kPixel : 0; }

/// Bytes of a record in a message, before any has been sent.
constexpr double record_bytes(const image::View& view) { return view.objects.empty() ? 8 : 12; }

}  // namespace motes::engine::render_costs
