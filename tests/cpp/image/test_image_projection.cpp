// What a message contains besides positions: systems, sprites, depths that others need, velocities, parts for each
// owner.
#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "image/project/projector.h"
#include "image/test_image_scene.h"
#include "support/check.h"

namespace motes::test_image_projection {
using namespace image_test;

TEST(image_messages_say_whose_records_they_have) {
  Projection projection;
  projection.system = 7;
  Sprite sprite{ImageSprite{{0x123456789abcdef}}, 0};
  sprite.blend = Sprite::Blend::alpha;
  sprite.softness = 0.25f;
  const auto bytes = projected(random_cloud(1000, 3).drawn(), sprite, small_view(), projection);
  const RecordsView view(bytes);
  CHECK(view.system() == 7 && view.sprite() == sprite && view.layout() == Layout::wide && view.count() > 100);
  Sprite part;
  part.of_height = 0.125f;
  const auto of_height = projected(random_cloud(1000, 3).drawn(), part, small_view(), projection);
  CHECK(RecordsView(of_height).sprite() == part);
}

TEST(image_light_has_a_depth_where_another_system_may_hide_it) {
  const Cloud cloud = random_cloud(5000, 3);
  const Projection alone;
  Projection behind;
  behind.any_depth = true;
  const auto plain = projected(cloud.drawn(), {}, small_view(), alone);
  const auto deep = projected(cloud.drawn(), {}, small_view(), behind);
  const RecordsView without(plain), with(deep);
  CHECK(without.layout() == Layout::plain && with.layout() == Layout::deep && without.count() == with.count());
  for (int tile = 0; tile < 12; ++tile) {
    const auto here = without.piece(without.batches()[0], tile), there = with.piece(with.batches()[0], tile);
    CHECK(here.count == there.count);
    for (std::size_t i = 0; i < here.count; ++i)
      CHECK(std::memcmp(here.records + 8 * i, there.records + 12 * i, 8) == 0);
  }
}

TEST(image_opaque_records_carry_velocities_for_their_layer) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  View view = small_view();
  view.layers = kVelocityLayer;
  for (const int pixels : {5, 0}) {
    Sprite ball{Sprite::Kind::sphere, pixels};
    const Cloud one(1);
    Drawn drawn = one.drawn();
    drawn.size_of_all = 0.1f;
    drawn.velocity_of_all = {1.5f, kInf, -2};
    CHECK(!RecordsView(projected(drawn, ball, view, {})).with_velocity());
    ball.blend = Sprite::Blend::opaque;
    const auto bytes = projected(drawn, ball, view, {});
    const RecordsView seen(bytes);
    CHECK(seen.with_velocity() && !seen.colored() && seen.record_bytes() == (pixels == 5 ? 20u : 24u));
    int found = 0;
    for (int tile = 0; tile < 12; ++tile) {
      const auto piece = seen.piece(seen.batches()[0], tile);
      if (piece.count == 0) continue;
      float velocity[3];
      std::memcpy(velocity, piece.records + seen.record_bytes() - sizeof velocity, sizeof velocity);
      CHECK(velocity[0] == 1.5f && velocity[1] == 0 && velocity[2] == -2);
      ++found;
    }
    CHECK(found > 0);
    view.layers = kDepthLayer;
    CHECK(!RecordsView(projected(drawn, ball, view, {})).with_velocity());
    view.layers = kVelocityLayer;
  }
}

TEST(image_parts_of_wide_messages_hold_the_records_of_their_slots) {
  Drawn drawn;
  const Cloud cloud = random_cloud(40000, 5);
  drawn = cloud.drawn();
  drawn.size_of_all = 0.3f;
  std::vector<std::uint32_t> order;
  for (std::uint32_t tile = 0; tile < 12; ++tile) order.push_back(11 - tile);
  const Slots slots(order);
  Projection projection;
  projection.slots = &slots;
  const auto all = projected(drawn, Sprite{Sprite::Kind::disc, 0}, small_view(), projection);
  const RecordsView whole(all);
  CHECK(whole.batches().size() > 1);
  std::size_t count = 0;
  for (int first = 0; first < 12; first += 5) {
    const int end = std::min(first + 5, 12);
    base::Bytes bytes;
    whole.append_part(first, end, bytes);
    const RecordsView part(bytes.view());
    CHECK(part.count() == whole.count(first, end) && part.sprite() == whole.sprite());
    for (int slot = 0; slot < 12; ++slot) {
      for (const auto& batch : part.batches()) {
        const auto piece = part.piece(batch, slot);
        CHECK((slot >= first && slot < end) || piece.count == 0);
        count += piece.count;
      }
    }
  }
  CHECK(count == whole.count());
}

}  // namespace motes::test_image_projection
