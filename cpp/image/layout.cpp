#include "image/layout.h"

#include <algorithm>

#include "image/grid.h"

namespace motes::image {
namespace {

bool has_fixed_footprint(const Sprite& sprite) {
  if (sprite.kind == Sprite::Kind::point) return true;
  return sprite.kind != Sprite::Kind::image && !(sprite.of_height > 0) && sprite.pixels >= 1 &&
         sprite.pixels <= kMaxFootprint;
}

}  // namespace

bool with_velocity(const Sprite& sprite, const View& view) {
  return (view.layers & kVelocityLayer) != 0 && sprite.blend == Sprite::Blend::opaque;
}

bool anything_hides(const View& view, std::span<const Sprite> sprites) {
  return !view.objects.empty() || std::any_of(sprites.begin(), sprites.end(),
                                              [](const Sprite& sprite) { return sprite.blend != Sprite::Blend::add; });
}

Layout layout(const Sprite& sprite, const View& view, bool any_depth) {
  if (view.shutter > 0 || !has_fixed_footprint(sprite)) return Layout::wide;
  const bool deep =
      any_depth || !view.objects.empty() || sprite.blend != Sprite::Blend::add || sprite.kind == Sprite::Kind::sphere;
  return deep ? Layout::deep : Layout::plain;
}

}  // namespace motes::image
