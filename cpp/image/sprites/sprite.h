// How the particles of one system are drawn: what all kinds of sprites have, and what one kind has (a file each).
//
//   Sprite = Look  +  pixels, of_height, softness, blend, lit, shadow, finish
//            point | disc | sphere | image | card | mesh | ribbon | surface
//
// Members are described where they are declared (base/members.h). From that follow the bytes in recorded lists and in
// messages of records, and the arguments that scripts give.
#pragma once

#include <cstdint>
#include <tuple>
#include <utility>
#include <variant>

#include "base/members.h"
#include "image/sprites/finish.h"
#include "image/sprites/liquid.h"
#include "image/sprites/mesh.h"
#include "image/sprites/picture.h"
#include "image/sprites/plain.h"
#include "image/sprites/ribbon.h"

namespace motes::image {

/// Largest diameter of any particle, px.
inline constexpr int kMaxDiameter = 512;

enum class SpriteKind : std::uint8_t {
#define MOTES_SPRITE_KIND(kind, Name) kind,
#include "image/sprites/list.inc"
};

template <class, class... Kinds>
struct OneOf {
  using Type = std::variant<Kinds...>;
};
using AnyLook = OneOf<void
#define MOTES_SPRITE_KIND(kind, Name) , Name##Sprite
#include "image/sprites/list.inc"
                      >::Type;

/// A kind of sprite and its members.
struct Look : AnyLook {
  using AnyLook::AnyLook;
  /// Makes a look of a kind whose members have their defaults.
  Look(SpriteKind kind = SpriteKind::disc);  // NOLINT(google-explicit-constructor): a kind is a look
};

template <class Visitor>
constexpr void fields(Visitor& visit, Look& look) {
  visit(static_cast<AnyLook&>(look));
}

struct Sprite {
  using Kind = SpriteKind;
  enum class Blend : std::uint8_t { add, alpha, opaque };

  Look look{};
  int pixels = 5;  // diameter, 1..kMaxDiameter; 0: the particle's size[0], m. Points have no diameter
  Blend blend = Blend::add;
  float of_height = 0;  // above 0: the diameter as a fraction of the picture's height, instead of `pixels`
  float softness = 0;  // distance, m, over which a particle fades where it touches an object
  bool lit = false;  // by the sun, lights and sky
  float shadow = 0;  // fraction of the light that one particle blocks, 0..1
  Finish finish{};

  static constexpr std::tuple kMembers{base::Member{"", &Sprite::look},
                                       base::Member{"pixels", &Sprite::pixels},
                                       base::Member{"blend", &Sprite::blend},
                                       base::Member{"of_height", &Sprite::of_height},
                                       base::Member{"softness", &Sprite::softness},
                                       base::Member{"lit", &Sprite::lit},
                                       base::Member{"shadow", &Sprite::shadow},
                                       base::Member{"", &Sprite::finish}};
  bool operator==(const Sprite&) const = default;

  Kind kind() const { return static_cast<Kind>(look.index()); }
  bool is(Kind one) const { return kind() == one; }
  /// Returns the members of a kind, or null if the sprite is of another.
  template <class OfKind>
  const OfKind* as() const {
    return std::get_if<OfKind>(&look);
  }
  /// Returns what the sprite shows, or null if it is of a kind without pictures.
  const Sheet* sheet() const;
  Sheet* sheet() { return const_cast<Sheet*>(std::as_const(*this).sheet()); }
  /// Returns whether it shows one of several tiles.
  bool tiled() const { return sheet() != nullptr && sheet()->tiles.cut(); }
  /// Returns the picture or mesh that it shows; 0: none.
  meshes::AssetKey asset() const;
  /// Returns the picture on its mesh; 0: none.
  meshes::AssetKey picture_on_mesh() const;
};

/// Returns whether the velocity of particles, not their orientation, rotates the sprite.
bool along_velocity(const Sprite& sprite);

/// Returns whether a sprite shows a surface in space, whose light depends on its normal and its finish. (Spheres as
/// small as points do not: see drawn_as_point.)
bool is_surface(const Sprite& sprite);

/// Returns whether particles cast shadows with edges, in depth maps: opaque ones that keep all light from what is
/// behind them, except ribbons. The others cast them in grids.
bool casts_sharply(const Sprite& sprite);
/// Returns whether particles keep the sky's light from what is near: see View::occlusion.
bool covers_sky(const Sprite& sprite);
inline bool casts_softly(const Sprite& sprite) { return sprite.shadow > 0 && !casts_sharply(sprite); }

/// Checks a sprite; throws std::invalid_argument naming the argument, its value and what is allowed.
void check(const Sprite& sprite);

/// Checks what sprites of all kinds have.
void check_common(const Sprite& sprite);

/// Returns the part of a sprite that painters need. Systems that differ only in the rest share a brush.
Sprite painted(Sprite sprite);

}  // namespace motes::image
