#include "image/layout.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "image/camera.h"
#include "image/daylight_parts.h"
#include "image/grid.h"

namespace motes::image {
namespace {

bool has_fixed_footprint(const Sprite& sprite, int height) {
  const float diameter = diameter_of(sprite, height);
  const bool flat = sprite.kind() != Sprite::Kind::image && !is_posed(sprite);
  return flat && diameter >= 2 && diameter <= static_cast<float>(kMaxFootprint);
}

// Returns whether sun and sky are the only light, of hardly more than white: then the light on a sphere depends on
// nothing but its normal, and small ones can be painted from tables.
bool has_even_light(const View& view) {
  if (!view.lights.empty() || view.sky.kind == Sky::Kind::picture) return false;
  const double height = length(view.sun) > 0 ? unit(view.sun)[1] : 0;
  for (std::size_t c = 0; c < 3; ++c) {
    double low = kBounce, high = kSky + kTint * double{view.background[c]};
    if (view.sky.kind == Sky::Kind::gradient) {
      low = high = double{std::max({view.sky.horizon[c], view.sky.zenith[c], view.sky.ground[c]})};
    }
    const double sun = kSun * double{view.sun_power} * double{view.sun_color[c]}, rise = 0.5 * (high - low);
    if (low + rise + std::sqrt(sun * sun + rise * rise + 2 * sun * rise * height) > 1.03) return false;
  }
  return true;
}

// Returns whether fog is the same in front of all points of each of the sprite's spheres, but for less than a step of
// 1/255. The light that passes changes with the distance by at most 1 / (e * distance), and no visible point is farther
// than 2/3 of the radius from the mean distance.
bool has_even_fog(const Sprite& sprite, const View& view) {
  constexpr double kMost = 255 * (2.0 / 3) * 0.36788;
  return sprite.blend == Sprite::Blend::opaque && sprite.is(Sprite::Kind::sphere) &&
         kMost * 0.5 * diameter_of(sprite, view.height) < lens(view).focal_px;
}

// Returns whether the light of a sprite depends on the normal at each of its points.
bool has_normals(const Sprite& sprite) { return is_surface(sprite) && !drawn_as_point(sprite); }

}  // namespace

bool is_posed(const Sprite& sprite) { return sprite.kind() >= Sprite::Kind::card && !sprite.is(Sprite::Kind::surface); }

bool drawn_as_point(const Sprite& sprite) {
  if (sprite.kind() == Sprite::Kind::point) return true;
  if (sprite.kind() == Sprite::Kind::image || is_posed(sprite)) return false;
  return sprite.pixels == 1 && !(sprite.of_height > 0);
}

float diameter_of(const Sprite& sprite, int height) {
  if (drawn_as_point(sprite)) return 2;
  if (sprite.of_height > 0) return sprite.of_height * static_cast<float>(height);
  return static_cast<float>(sprite.pixels == 1 ? 2 : sprite.pixels);
}

bool has_gain(const Sprite& sprite, const View& view) {
  return sprite.lit && sprite.is(Sprite::Kind::image) && (!view.lights.empty() || view.sun_power > 1);
}

bool has_grey_light(const View& view) {
  constexpr float kAlike = 0.01f;
  const auto grey = [](const Color& color) {
    const auto [least, most] = std::minmax_element(color.begin(), color.end());
    return *most - *least <= kAlike * std::max(*most, 1.0f);
  };
  return view.sky.kind == Sky::Kind::none && grey(view.sun_color) && grey(view.background);
}

bool lit_by_painter(const Sprite& sprite) { return (sprite.lit || sprite.finish.reflects()) && has_normals(sprite); }

bool fogged_by_painter(const Sprite& sprite, const View& view) {
  if (!(view.fog.metres > 0) || sprite.blend == Sprite::Blend::add) return false;
  return has_normals(sprite) || sprite.is(Sprite::Kind::image);
}

namespace {

// Makes a sprite as large, and as bright, in a preview as in the whole picture. Opaque points stay pixels.
void scale_to_preview(Sprite& sprite, const View& view) {
  const bool point = drawn_as_point(sprite);
  if (view.full_height == 0 || sprite.of_height > 0 || !(point || sprite.pixels > 0)) return;
  if (point && sprite.blend == Sprite::Blend::opaque) return;
  sprite.of_height = diameter_of(sprite, view.full_height) / static_cast<float>(view.full_height);
  if (point) sprite.look = Sprite::Kind::disc;
}

}  // namespace

Sprite as_seen(Sprite sprite, const View& view) {
  scale_to_preview(sprite, view);
  if (!(view.camera.aperture > 0) || sprite.blend == Sprite::Blend::opaque) return sprite;
  if (const auto* image = sprite.as<ImageSprite>()) sprite.look = CardSprite{image->sheet, Facing::camera};
  return sprite;
}

bool blurs_in_painter(const Sprite& sprite) {
  return sprite.blend == Sprite::Blend::opaque || is_posed(sprite) ||
         (sprite.is(Sprite::Kind::sphere) && !drawn_as_point(sprite));
}

bool with_velocity(const Sprite& sprite, const View& view) {
  const auto* liquid = sprite.as<LiquidSprite>();
  const bool foams = liquid != nullptr && liquid->foam > 0;
  return foams || ((view.layers & kVelocityLayer) != 0 && sprite.blend == Sprite::Blend::opaque);
}

bool in_order_of_depth(std::span<const Sprite> sprites) {
  return std::any_of(sprites.begin(), sprites.end(),
                     [](const Sprite& sprite) { return sprite.blend == Sprite::Blend::alpha; });
}

bool anything_hides(const View& view, std::span<const Sprite> sprites) {
  return !view.objects.empty() || std::any_of(sprites.begin(), sprites.end(),
                                              [](const Sprite& sprite) { return sprite.blend != Sprite::Blend::add; });
}

Layout layout(const Sprite& sprite, const View& view, bool any_depth) {
  const bool deep = any_depth || !view.objects.empty() || sprite.blend != Sprite::Blend::add ||
                    (sprite.kind() == Sprite::Kind::sphere && !drawn_as_point(sprite));
  if (sprite.kind() == Sprite::Kind::ribbon) return Layout::ribbon;
  if (is_posed(sprite)) return sprite.tiled() ? Layout::posed_tiled : Layout::posed;
  if (sprite.tiled()) return Layout::tiled;
  if (has_gain(sprite, view)) return Layout::wide;
  const bool still = !(view.shutter > 0);
  const bool sharp = !(view.camera.aperture > 0);
  const bool surface = lit_by_painter(sprite) && (sprite.finish.reflects() || !has_even_light(view));
  const bool simple = !surface && (!fogged_by_painter(sprite, view) || has_even_fog(sprite, view));
  if (still && sharp && simple && has_fixed_footprint(sprite, view.height)) return deep ? Layout::deep : Layout::plain;
  const bool far = !sharp && blurs_in_painter(sprite);  // may reach the image from far outside
  if (far || sprite.kind() == Sprite::Kind::image || Grid{view.width, view.height}.far_bits() == 0) return Layout::wide;
  if (still) return deep ? Layout::deep_sized : Layout::sized;
  return deep ? Layout::deep_moving : Layout::moving;
}

}  // namespace motes::image
