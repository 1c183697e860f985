#include "image/sprites/sprite.h"

#include <string>

#include "base/checks.h"
#include "base/enumerators.h"

namespace motes::image {

Look::Look(SpriteKind kind) {
  switch (kind) {
#define MOTES_SPRITE_KIND(kind, Name) \
  case SpriteKind::kind: emplace<Name##Sprite>(); break;
#include "image/sprites/list.inc"
  }
}

const Sheet* Sprite::sheet() const {
  return std::visit(
      [](const auto& own) -> const Sheet* {
        if constexpr (requires { own.sheet; }) return &own.sheet;
        return nullptr;
      },
      look);
}

meshes::AssetKey Sprite::asset() const {
  if (const auto* own = as<MeshSprite>()) return own->mesh;
  return sheet() == nullptr ? 0 : sheet()->picture;
}

meshes::AssetKey Sprite::picture_on_mesh() const {
  const auto* own = as<MeshSprite>();
  return own == nullptr ? 0 : own->picture;
}

bool is_surface(const Sprite& sprite) {
  using Kind = Sprite::Kind;
  return sprite.is(Kind::sphere) || sprite.is(Kind::card) || sprite.is(Kind::mesh);
}

bool along_velocity(const Sprite& sprite) {
  return std::visit(
      [](const auto& own) {
        if constexpr (requires { own.facing; }) return own.facing == Facing::velocity;
        return false;
      },
      sprite.look);
}

bool casts_sharply(const Sprite& sprite) { return sprite.shadow == 1 && covers_sky(sprite); }

bool covers_sky(const Sprite& sprite) {
  return sprite.blend == Sprite::Blend::opaque && !sprite.is(Sprite::Kind::ribbon);
}

void check_common(const Sprite& sprite) {
  if (static_cast<int>(sprite.blend) >= base::enumerators<Sprite::Blend>()) {
    base::refuse("sprite.blend", base::names_of<Sprite::Blend>(), std::to_string(static_cast<int>(sprite.blend)));
  }
  base::check_number("sprite.of_height", sprite.of_height, 0, 1);
  base::check_number("sprite.softness", sprite.softness, 0, base::kFarthest);
  base::check_number("sprite.shadow", sprite.shadow, 0, 1);
  base::check_number("sprite.roughness", sprite.finish.roughness, 0, 1);
  base::check_number("sprite.metal", sprite.finish.metal, 0, 1);
  if (sprite.finish.reflects() && (!is_surface(sprite) || (sprite.is(Sprite::Kind::card) && !sprite.lit))) {
    base::refuse("sprite.roughness", "1, and metal 0, for all but spheres, meshes and lit cards",
                 std::to_string(sprite.finish.roughness));
  }
  const bool counted_in_pixels = !sprite.is(Sprite::Kind::point) && !(sprite.of_height > 0);
  if (counted_in_pixels && (sprite.pixels < 0 || sprite.pixels > kMaxDiameter)) {
    base::refuse("sprite.pixels", "0.." + std::to_string(kMaxDiameter), std::to_string(sprite.pixels));
  }
  if (sprite.is(Sprite::Kind::mesh) && (sprite.pixels != 0 || sprite.of_height > 0)) {
    base::refuse("sprite.pixels", "0 for kind mesh: it is scaled by size", std::to_string(sprite.pixels));
  }
}

void check(const Sprite& sprite) {
  check_common(sprite);
  std::visit(
      [](const auto& own) {
        if constexpr (requires { check(own); }) check(own);
      },
      sprite.look);
}

Sprite painted(Sprite sprite) {
  if (!is_surface(sprite)) {
    sprite.lit = false;
    sprite.finish = {};
  }
  sprite.shadow = 0;
  std::visit(
      [](auto& own) {
        if constexpr (requires { own.painted(); }) own = own.painted();
      },
      sprite.look);
  return sprite;
}

}  // namespace motes::image
