// What all and what single kinds of sprites have: bytes, messages, brushes.
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/fields.h"
#include "image/project/records.h"
#include "image/raster/brush.h"
#include "image/sprites/sprite.h"
#include "image/test_image_wide_scene.h"
#include "support/check.h"

namespace motes::test_image_sprites {
using namespace image_test;

namespace {

// Calls use(name, member) for each member that is not a struct with members of its own.
template <class T, class Use>
void for_each_leaf(T& value, const Use& use) {
  base::for_each_member(value, [&](const char* name, auto& member) {
    using Member = std::remove_reference_t<decltype(member)>;
    if constexpr (base::Described<Member>) {
      for_each_leaf(member, use);
    } else if constexpr (std::is_same_v<Member, Look>) {
      std::visit([&](auto& own) { for_each_leaf(own, use); }, member);
    } else {
      use(name, member);
    }
  });
}

template <class T>
void change(T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    value = !value;
  } else if constexpr (std::is_enum_v<T>) {
    value = static_cast<T>(value == T{} ? 1 : 0);
  } else {
    value = static_cast<T>(value + 1);
  }
}
void change(Tiles& tiles) { tiles = {2, 1, 2}; }
void change(Pick& pick) { pick.shapes.emplace_back(); }

std::vector<Sprite> of_each_kind() {
  std::vector<Sprite> all;
  for (std::size_t i = 0; i < std::variant_size_v<AnyLook>; ++i) all.push_back({static_cast<Sprite::Kind>(i)});
  return all;
}

// Returns copies of a sprite, each with another member changed.
std::vector<Sprite> variations(const Sprite& sprite) {
  std::size_t number = 0;
  Sprite copy = sprite;
  for_each_leaf(copy, [&](const char*, auto&) { ++number; });
  std::vector<Sprite> all;
  for (std::size_t which = 0; which < number; ++which) {
    Sprite& changed = all.emplace_back(sprite);
    std::size_t i = 0;
    for_each_leaf(changed, [&](const char*, auto& member) {
      if (i++ == which) change(member);
    });
  }
  return all;
}

// A struct whose description leaves out a member: it has no fields().
struct Forgets {
  int told = 1;
  bool forgotten = false;

  static constexpr std::tuple kMembers{base::Member{"told", &Forgets::told}};
};
static_assert(base::members<Forgets>() == 2 && std::tuple_size_v<decltype(Forgets::kMembers)> == 1);
static_assert(base::members<PointSprite>() == 0 && base::members<CardSprite>() == 2 && base::members<Sheet>() == 3);

base::Bytes bytes_of(const Sprite& sprite) {
  base::Bytes bytes;
  base::write_fields(sprite, bytes);
  return bytes;
}

bool equal(const base::Bytes& a, const base::Bytes& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace

TEST(image_each_member_of_a_sprite_is_in_its_bytes) {
  for (const Sprite& sprite : of_each_kind()) {
    for (const Sprite& other : variations(sprite)) {
      const base::Bytes bytes = bytes_of(other);
      CHECK(!(other == sprite) && !equal(bytes, bytes_of(sprite)));
      base::Reader in(bytes.view());
      Sprite read;
      base::read_fields(in, read);
      CHECK(read == other && in.left() == 0);
    }
  }
  CHECK(variations(Sprite{Sprite::Kind::ribbon}).size() == 10 && variations(Sprite{Sprite::Kind::card}).size() == 12);
}

TEST(image_kinds_of_sprites_keep_their_numbers) {
  const std::vector<Sprite> all = of_each_kind();
  for (std::size_t i = 0; i < all.size(); ++i) CHECK(bytes_of(all[i]).data()[0] == static_cast<std::byte>(i));
  CHECK(all[0].as<PointSprite>() != nullptr && all[3].as<ImageSprite>() != nullptr && all[6].as<RibbonSprite>());
  base::Bytes none = bytes_of(all[0]);
  none.data()[0] = static_cast<std::byte>(all.size());
  base::Reader in(none.view());
  Sprite read;
  CHECK_THROWS(base::read_fields(in, read), std::runtime_error);
}

TEST(image_messages_carry_what_painters_need_of_a_sprite) {
  const View view = small_view();
  const Cloud cloud = random_cloud(100, 3);
  Sprite leaf{ImageSprite{{two_colors(), {2, 2, 3}}}, 0};
  leaf.softness = 0.5f;
  leaf.lit = true;
  leaf.shadow = 0.25f;
  Sprite seen = leaf;
  seen.lit = false;
  seen.shadow = 0;
  Drawn drawn = cloud.drawn();
  const std::vector<float> tile(cloud.count + 16, 1.0f);
  drawn.tile = tile.data();
  const auto bytes = projected(drawn, leaf, view, {});
  CHECK(RecordsView(bytes).sprite() == seen);
  for (const Sprite& other : variations(leaf)) {
    const bool dropped = painted(other) == painted(leaf);
    CHECK(dropped == (other.lit != leaf.lit || other.shadow != leaf.shadow || !(other.finish == leaf.finish) ||
                      other.sheet()->pick != leaf.sheet()->pick));
  }
}

TEST(image_brushes_are_ordered_by_all_that_painters_need) {
  const View view = small_view();
  const Sprite leaf{CardSprite{{two_colors(), {2, 2, 3}}}, 0};
  for (const Sprite& other : variations(leaf)) {
    if (painted(other) == painted(leaf) || other.asset() != leaf.asset()) continue;
    const Brush one(painted(leaf), Layout::posed_tiled, view), two(painted(other), Layout::posed_tiled, view);
    CHECK(((one <=> two) < 0) == ((two <=> one) > 0) && ((one <=> two) > 0) == ((two <=> one) < 0));
    CHECK((one <=> two) != 0);
  }
}

}  // namespace motes::test_image_sprites
