#include "image/layout.h"

#include <algorithm>
#include <variant>

#include "image/daylight_parts.h"
#include "image/grid.h"

namespace motes::image {
namespace {

bool has_fixed_footprint(const Sprite& sprite, int height) {
  const float diameter = diameter_of(sprite, height);
  const bool flat = sprite.kind() != Sprite::Kind::image && !is_posed(sprite);
  return flat && diameter >= 2 && diameter <= static_cast<float>(kMaxFootprint);
}

// Returns whether sun and sky are the only light, of no colour and at most white: then one number per pixel is the
// light on a sphere (see Daylight), and small ones can be painted from tables.
bool has_grey_light(const View& view) {
  constexpr float kAlike = 0.01f;
  const auto grey = [](const Color& color) {
    const auto [least, most] = std::minmax_element(color.begin(), color.end());
    return *most - *least <= kAlike * std::max(*most, 1.0f);
  };
  const float background = *std::max_element(view.background.begin(), view.background.end());
  const bool dim = static_cast<float>(kSun) * view.sun_power * view.sun_color[0] + static_cast<float>(kSky) +
                       static_cast<float>(kTint) * background <=
                   1;
  return view.lights.empty() && view.sky.kind == Sky::Kind::none && grey(view.sun_color) && grey(view.background) &&
         dim;
}

// Returns whether a sprite shows a surface in space, whose light depends on its normal.
bool is_surface(const Sprite& sprite) {
  return (sprite.is(Sprite::Kind::sphere) && !drawn_as_point(sprite)) || sprite.is(Sprite::Kind::card) ||
         sprite.is(Sprite::Kind::mesh);
}

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

bool lit_by_painter(const Sprite& sprite) { return sprite.lit && is_surface(sprite); }

bool fogged_by_painter(const Sprite& sprite, const View& view) {
  if (!(view.fog.metres > 0) || sprite.blend == Sprite::Blend::add) return false;
  return is_surface(sprite) || sprite.is(Sprite::Kind::image);
}

Sprite as_seen(Sprite sprite, const View& view) {
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
  const bool simple = !(lit_by_painter(sprite) && !has_grey_light(view)) && !fogged_by_painter(sprite, view);
  if (still && sharp && simple && has_fixed_footprint(sprite, view.height)) return deep ? Layout::deep : Layout::plain;
  const bool far = !sharp && blurs_in_painter(sprite);  // may reach the image from far outside
  if (far || sprite.kind() == Sprite::Kind::image || Grid{view.width, view.height}.far_bits() == 0) return Layout::wide;
  if (still) return deep ? Layout::deep_sized : Layout::sized;
  return deep ? Layout::deep_moving : Layout::moving;
}

}  // namespace motes::image
