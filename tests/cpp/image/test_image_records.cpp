#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <stdexcept>

#include "base/vectors.h"
#include "image/camera.h"
#include "image/checks.h"
#include "image/curves.h"
#include "image/footprint.h"
#include "image/layout.h"
#include "image/test_image_scene.h"
#include "support/check.h"

namespace motes::test_image_records {
using namespace image_test;

namespace {

struct Record {
  std::int16_t x, y;
  std::uint32_t color;
  float depth;
  int tile;
};

std::vector<Record> records_of(const std::vector<std::byte>& bytes) {
  const RecordsView view(bytes);
  const RecordForm f = form(view.layout(), view.colored());
  std::vector<Record> records;
  for (const auto& batch : view.batches()) {
    for (int tile = 0; tile < view.grid().tiles(); ++tile) {
      const auto piece = view.piece(batch, tile);
      for (std::size_t i = 0; i < piece.count; ++i) {
        Record r{};
        const std::byte* from = piece.records + i * view.record_bytes();
        std::memcpy(&r.x, from, 2);
        std::memcpy(&r.y, from + 2, 2);
        r.color = view.color();
        if (f.color != 0) std::memcpy(&r.color, from + f.color, 4);
        if (f.depth != 0) std::memcpy(&r.depth, from + f.depth, 4);
        r.tile = tile;
        records.push_back(r);
      }
    }
  }
  return records;
}

View with_object(View view) {
  Solid far_wall;
  far_wall.shape.kind = shapes::Kind::sphere;
  far_wall.shape.number[2] = -500;
  far_wall.shape.number[3] = 1;
  view.objects = {far_wall};
  return view;
}

}  // namespace

TEST(image_projection_agrees_with_double_precision) {
  View view = with_object(small_view(320, 200));
  view.camera = {{3, 4, 9}, {0.5, -1, 0}, {0.1, 1, 0}, 55, 0.1};
  const Lens l = lens(view);
  const Cloud cloud = random_cloud(3000, 7, false);
  int seen = 0, expected = 0;
  for (std::size_t i = 0; i < cloud.count; ++i) {
    Cloud one(1);
    one.place(0, cloud.plane[0][i], cloud.plane[1][i], cloud.plane[2][i]);
    const auto found = records_of(message(one, {Sprite::Kind::disc, 5}, view));
    const Vector offset = Vector{one.plane[0][0], one.plane[1][0], one.plane[2][0]} - l.eye;
    const double z = dot(offset, l.forward);
    const double x = l.focal_px * dot(offset, l.right) / z, y = -l.focal_px * dot(offset, l.up) / z;
    expected += z > 0.1 && std::fabs(x) < 159 && std::fabs(y) < 99;
    if (found.empty()) {
      CHECK(z < 0.1 || std::fabs(x) > 161.9 || std::fabs(y) > 101.9);
      continue;
    }
    ++seen;
    CHECK_NEAR(found[0].x, std::floor(x * 16), 1);
    CHECK_NEAR(found[0].y, std::floor(y * 16), 1);
    CHECK_NEAR(found[0].depth, z, 1e-5 * z);
    CHECK(found[0].color == 0xffffffffu);
  }
  CHECK(seen >= expected && expected > 100);
}

TEST(image_tangent_and_srgb_are_right) {
  for (double degrees = 0.5; degrees < 89.9; degrees += 0.7) {
    const double x = degrees * 3.14159265358979323846 / 180;
    CHECK_NEAR(tangent(x) / std::tan(x), 1, 1e-13);
  }
  for (double x = 0; x <= 1; x += 0.003) {
    const double expected = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    CHECK_NEAR(srgb(x), expected, 1e-12);
  }
}

TEST(image_records_are_the_same_bytes_for_every_isa) {
  for (const bool colored : {false, true}) {
    const Cloud cloud = random_cloud(40001, 3, colored);
    for (const View& view : {small_view(), with_object(small_view(333, 65))}) {
      for (const int pixels : {1, 4, 15}) {
        const auto reference = message(cloud, {Sprite::Kind::disc, pixels}, view, *usable_project_lanes().front());
        CHECK(RecordsView(reference).count() > 1000);
        for (const auto* lanes : usable_project_lanes()) {
          CHECK(message(cloud, {Sprite::Kind::disc, pixels}, view, *lanes) == reference);
        }
      }
    }
  }
}

// Numbers of tiles beyond 2^15, in a batch of several vectors.
TEST(image_records_of_the_largest_picture_find_their_tiles) {
  const View view = small_view(kMaxSize, kMaxSize);
  const int columns = kMaxSize / kTile;
  for (const auto* lanes : usable_project_lanes()) {
    Cloud cloud(37);
    for (std::size_t i = 0; i < cloud.count; ++i) {
      const float x = i % 2 == 0 ? -3.6f : 3.6f, y = i % 4 < 2 ? 3.6f : -3.6f;
      cloud.place(i, x, y, 0);
    }
    int corners[4] = {};
    for (const Record& r : records_of(message(cloud, {Sprite::Kind::point, 1}, view, *lanes))) {
      const int column = r.tile % columns, row = r.tile / columns;
      const int half = 1 << (Grid{kMaxSize, kMaxSize}.sub_bits() - 1);
      CHECK(column == (r.x + kMaxSize * half) / (2 * half) / kTile);
      CHECK(row == (r.y + kMaxSize * half) / (2 * half) / kTile);
      ++corners[2 * (row < columns / 2 ? 0 : 1) + (column < columns / 2 ? 0 : 1)];
    }
    CHECK(corners[0] == 10 && corners[1] == 9 && corners[2] == 9 && corners[3] == 9);
  }
}

TEST(image_records_stand_in_every_tile_they_touch_and_only_once) {
  const View view = small_view(200, 150);
  for (const auto& sprite :
       {Sprite{Sprite::Kind::point, 1}, Sprite{Sprite::Kind::disc, 6}, Sprite{Sprite::Kind::disc, 15}}) {
    const int size = footprint_size(sprite, view.height);
    const Cloud cloud = random_cloud(500, 11, false);
    for (std::size_t i = 0; i < cloud.count; ++i) {
      Cloud one(1);
      one.place(0, cloud.plane[0][i], cloud.plane[1][i], cloud.plane[2][i]);
      const auto found = records_of(message(one, sprite, view));
      std::set<int> tiles, expected;
      for (const auto& r : found) tiles.insert(r.tile);
      CHECK(tiles.size() == found.size());
      if (found.empty()) continue;
      const int left = (found[0].x + 8 * (201 - size)) >> 4, top = (found[0].y + 8 * (151 - size)) >> 4;
      for (int y = std::max(top, 0); y < std::min(top + size, 150); ++y) {
        for (int x = std::max(left, 0); x < std::min(left + size, 200); ++x) expected.insert(y / 64 * 4 + x / 64);
      }
      CHECK(tiles == expected);
    }
  }
}

TEST(image_colors_are_rounded_and_clamped) {
  const View view = small_view();
  Cloud cloud(4, true);
  cloud.color[0] = {0.5f, -1, 2, NAN};
  cloud.color[1] = {0.25f, 0.1f, 0.1f, 1};
  cloud.color[2] = {1, 0.1f, 0.1f, 1};
  cloud.alpha = {0.5f, 1, 0, 7};
  for (auto* column : {&cloud.color[0], &cloud.color[1], &cloud.color[2], &cloud.alpha}) column->resize(20);
  const auto found = records_of(message(cloud, {}, view));
  CHECK(found.size() == 3);  // alpha 0 gives no light
  CHECK(found[0].color == (0x80u | 0x40u << 8 | 0xffu << 16 | 0x80u << 24));
  CHECK(found[1].color == (0x00u | 0x1au << 8 | 0x1au << 16 | 0xffu << 24));
  CHECK(found[2].color == 0xffffff00u);
}

TEST(image_particles_that_cannot_be_seen_are_culled) {
  const View view = small_view();
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const float huge = std::numeric_limits<float>::max();
  const float places[][3] = {{nan, 0, 0},      {0, nan, 0}, {0, 0, nan},   {inf, 0, 0},  {0, -inf, 0}, {0, 0, inf},
                             {0, 0, -inf},     {0, 0, 10},  {0, 0, 9.95f}, {0, 0, 11},   {0, 0, huge}, {huge, 0, 0},
                             {0, huge, -huge}, {100, 0, 0}, {0, -100, 0},  {0, 0, -huge}};
  for (const auto* lanes : usable_project_lanes()) {
    for (std::size_t i = 0; i < 15; ++i) {
      Cloud one(1);
      one.place(0, places[i][0], places[i][1], places[i][2]);
      CHECK(RecordsView(message(one, {}, view, *lanes)).count() == 0);
    }
    Cloud far(1);
    far.place(0, 0, 0, -1e30f);
    CHECK(RecordsView(message(far, {}, view, *lanes)).count() >= 1);
  }
}

TEST(image_empty_systems_give_empty_messages) {
  const auto bytes = message(Cloud(0), {}, small_view());
  CHECK(bytes.size() == sizeof(RecordsHead) + 32);  // and the sprite
  CHECK(RecordsView(bytes).count() == 0);
  Drawn nowhere;
  nowhere.count = 5;
  Records records;
  CHECK_THROWS(Projector().project(nowhere, {}, small_view(), records), std::invalid_argument);
}

TEST(image_parts_of_a_message_hold_the_records_of_their_tiles) {
  for (const View& view : {small_view(), with_object(small_view())}) {
    const auto all = message(random_cloud(60000, 5), {}, view);
    const RecordsView whole(all);
    CHECK(whole.batches().size() == 2);
    const std::vector<int> ends{0, 0, 1, 5, 5, 11, 12};
    std::size_t count = 0;
    for (std::size_t i = 1; i < ends.size(); ++i) {
      base::Bytes bytes;
      bytes.put(std::uint8_t{1});  // parts may start anywhere
      whole.append_part(ends[i - 1], ends[i], bytes);
      const RecordsView part(bytes.view().subspan(1));
      CHECK(part.count() == whole.count(ends[i - 1], ends[i]));
      count += part.count();
      for (int tile = 0; tile < 12; ++tile) {
        const bool inside = tile >= ends[i - 1] && tile < ends[i];
        std::vector<std::byte> here, there;
        for (const auto& batch : part.batches()) {
          const auto piece = part.piece(batch, tile);
          here.insert(here.end(), piece.records, piece.records + piece.count * part.record_bytes());
        }
        for (const auto& batch : whole.batches()) {
          const auto piece = whole.piece(batch, tile);
          there.insert(there.end(), piece.records, piece.records + piece.count * whole.record_bytes());
        }
        CHECK(here == (inside ? there : std::vector<std::byte>{}));
      }
      base::Bytes nothing;
      CHECK_THROWS(part.append_part(0, 12, nothing), std::invalid_argument);
    }
    CHECK(count == whole.count());
  }
}

// Returns the records in a slot, in order.
std::vector<std::byte> in_slot(const RecordsView& view, int slot) {
  std::vector<std::byte> found;
  for (const auto& batch : view.batches()) {
    const auto piece = view.piece(batch, slot);
    found.insert(found.end(), piece.records, piece.records + piece.count * view.record_bytes());
  }
  return found;
}

TEST(image_counts_of_records_add_up_by_slot) {
  const View view = small_view(640, 360);
  const auto bytes = message(random_cloud(40000, 3), {Sprite::Kind::disc, 5}, view);
  const RecordsView all(bytes);
  const auto slots = static_cast<std::size_t>(all.grid().tiles());
  base::Bytes part;
  all.append_part(7, 20, part);
  std::vector<std::uint32_t> counts(slots, 1);
  all.add_counts(counts);
  RecordsView(part.view()).add_counts(counts);
  for (std::size_t s = 0; s < slots; ++s) {
    std::size_t wanted = 1;
    for (const auto& batch : all.batches())
      wanted += all.piece(batch, static_cast<int>(s)).count * (s >= 7 && s < 20 ? 2 : 1);
    CHECK(counts[s] == wanted);
  }
}

TEST(image_slots_are_tiles_in_another_order) {
  const View view = small_view(333, 200);  // 6 x 4 tiles
  const Cloud cloud = random_cloud(40000, 5);
  std::vector<std::uint32_t> order;
  for (std::uint32_t owner = 0; owner < 5; ++owner) {
    for (std::uint32_t tile = owner; tile < 24; tile += 5) order.push_back(tile);
  }
  const Slots slots(order);
  for (int tile = 0; tile < 24; ++tile) CHECK(slots.tile(slots.slot(tile)) == tile);
  Projection projection;
  projection.slots = &slots;
  const Sprite in_metres{Sprite::Kind::disc, 0};
  for (const Sprite& sprite : {Sprite{}, in_metres}) {
    Projector projector;
    Records by_tile, by_slot;
    Drawn drawn = cloud.drawn();
    drawn.size_of_all = 0.5f;
    projector.project(drawn, sprite, view, by_tile);
    projector.project(drawn, sprite, view, by_slot, projection);
    const RecordsView tiles(by_tile.bytes()), in_order(by_slot.bytes());
    CHECK(tiles.count() > 20000 && tiles.count() == in_order.count());
    for (int tile = 0; tile < 24; ++tile) CHECK(in_slot(tiles, tile) == in_slot(in_order, slots.slot(tile)));
  }
  const Slots too_few({0, 1, 2});
  projection.slots = &too_few;
  Records records;
  CHECK_THROWS(Projector().project(cloud.drawn(), {}, view, records, projection), std::invalid_argument);
  CHECK_THROWS(Slots({0, 2}), std::invalid_argument);
  CHECK_THROWS(Slots({1, 1}), std::invalid_argument);
}

TEST(image_malformed_records_are_refused) {
  const View view = small_view();
  const auto good = message(random_cloud(1000, 5, false), {}, view);
  CHECK(RecordsView(good).count() > 100 && !RecordsView(good).colored());
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 8) {
    const std::vector<std::byte> cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    CHECK_THROWS(RecordsView(cut), std::runtime_error);
  }
  auto longer = good;
  longer.push_back(std::byte{0});
  CHECK_THROWS(RecordsView(longer), std::runtime_error);
  constexpr std::size_t kSprite = sizeof(RecordsHead), kOffsets = kSprite + 32;
  for (const std::size_t at : {offsetof(RecordsHead, magic),
                               offsetof(RecordsHead, sprite_bytes),
                               offsetof(RecordsHead, layout),
                               offsetof(RecordsHead, with_velocity),
                               offsetof(RecordsHead, colored),
                               offsetof(RecordsHead, width) + 3,
                               offsetof(RecordsHead, height) + 3,
                               offsetof(RecordsHead, first_slot),
                               offsetof(RecordsHead, slots),
                               offsetof(RecordsHead, batches),
                               offsetof(RecordsHead, records),
                               offsetof(RecordsHead, records) + 7,
                               kSprite,
                               kSprite + 1,
                               kSprite + 4,
                               kSprite + 5,
                               kSprite + 9,
                               kSprite + 13,
                               kSprite + 14,
                               kSprite + 18,
                               kOffsets,
                               kOffsets + 3,
                               kOffsets + 8,
                               kOffsets + 19,
                               kOffsets + 48}) {
    auto bad = good;
    bad[at] = std::byte{0xee};
    CHECK_THROWS(RecordsView(bad), std::runtime_error);
  }
  auto blended = good;
  blended[kSprite + 5] = static_cast<std::byte>(Sprite::Blend::alpha);
  CHECK_THROWS(RecordsView(blended), std::runtime_error);  // without colours
  Canvas canvas;
  canvas.begin(small_view(64, 64));
  CHECK_THROWS(canvas.add(good), std::runtime_error);
  canvas.begin(with_object(view));
  CHECK_THROWS(canvas.add(good), std::runtime_error);
}

TEST(image_nonsense_positions_stay_inside_memory) {
  const View view = small_view();
  auto bytes = message(random_cloud(2000, 5), {Sprite::Kind::disc, 15}, view);
  const std::size_t header = sizeof(RecordsHead) + 32 + 4 * 13;
  std::uint32_t state = 1;
  for (std::size_t i = header; i < bytes.size(); ++i) {
    state = state * 1664525u + 1013904223u;
    bytes[i] = static_cast<std::byte>(state >> 24);
  }
  for (const auto* lanes : usable_splat_lanes()) CHECK(picture(view, {bytes}, *lanes).size() == 200 * 150 * 3);
}

TEST(image_views_and_sprites_are_checked) {
  const auto refused = [](auto change) {
    View view = small_view();
    change(view);
    CHECK_THROWS(image::check(view), std::invalid_argument);
  };
  image::check(small_view());
  refused([](View& v) { v.width = 0; });
  refused([](View& v) { v.height = 16385; });
  refused([](View& v) { v.camera.position[1] = NAN; });
  refused([](View& v) { v.camera.look_at = v.camera.position; });
  refused([](View& v) { v.camera.up = {0, 0, -3}; });
  refused([](View& v) { v.camera.up = {0, 0, 0}; });
  refused([](View& v) { v.camera.fov_deg = 0; });
  refused([](View& v) { v.camera.fov_deg = 180; });
  refused([](View& v) { v.camera.near = 0; });
  refused([](View& v) { v.exposure = -1; });
  refused([](View& v) { v.exposure = NAN; });
  refused([](View& v) { v.background[2] = -0.1f; });
  refused([](View& v) { v.objects.push_back({}); });  // a point is not drawn
  refused([](View& v) { v.sun[1] = INFINITY; });
  refused([](View& v) { v.shutter = 4.1f; });
  refused([](View& v) { v.shutter = NAN; });
  refused([](View& v) { v.bloom = -0.1f; });
  refused([](View& v) { v.layers = 8; });
  refused([](View& v) { v.path = static_cast<View::Path>(4); });
  refused([](View& v) { v.lights = {{{0, NAN, 0}, {1, 1, 1}, 1}}; });
  refused([](View& v) { v.lights = {{{0, 0, 0}, {1, -1, 1}, 1}}; });
  refused([](View& v) { v.lights = {{{0, 0, 0}, {1, 1, 1}, -1}}; });
  refused([](View& v) {
    v.before = v.camera;
    v.before->fov_deg = 181;
  });
}

TEST(image_sprites_are_checked) {
  const auto refused = [](auto change) {
    Sprite sprite;
    change(sprite);
    CHECK_THROWS(image::check(sprite), std::invalid_argument);
  };
  image::check(Sprite{});
  image::check(Sprite{Sprite::Kind::sphere, 0});
  image::check(Sprite{Sprite::Kind::disc, 512});
  refused([](Sprite& s) { s.pixels = -1; });
  refused([](Sprite& s) { s.pixels = 513; });
  refused([](Sprite& s) { s.blend = static_cast<Sprite::Blend>(3); });
  refused([](Sprite& s) { s.of_height = -0.1f; });
  refused([](Sprite& s) { s.of_height = NAN; });
  refused([](Sprite& s) { s.softness = -1; });
  refused([](Sprite& s) { s.softness = INFINITY; });
  for (const auto kind : {Sprite::Kind::image, Sprite::Kind::card, Sprite::Kind::mesh, Sprite::Kind::ribbon}) {
    refused([&](Sprite& s) { s.look = kind; });  // without a picture, mesh or width
  }
  refused([](Sprite& s) { s.look = ImageSprite{{1, {3, 1, 4}}}; });
}

TEST(image_layout_follows_from_sprite_and_view) {
  const View view = small_view();
  View open = view;
  open.shutter = 0.5f;
  const Sprite disc, point{Sprite::Kind::point, 99}, in_metres{Sprite::Kind::disc, 0}, large{Sprite::Kind::disc, 16};
  const Sprite sphere{Sprite::Kind::sphere, 5};
  Sprite smoke, part, narrow, broad, leaf;
  smoke.blend = Sprite::Blend::alpha;
  part.of_height = 4.5f / static_cast<float>(view.height);
  narrow.of_height = 1.5f / static_cast<float>(view.height);
  broad.of_height = 16.5f / static_cast<float>(view.height);
  leaf.look = Sprite::Kind::image;
  for (const Sprite& sprite : {disc, point}) {
    CHECK(layout(sprite, view, false) == Layout::plain);
    CHECK(layout(sprite, view, true) == Layout::deep);
    CHECK(layout(sprite, with_object(view), false) == Layout::deep);
    CHECK(layout(sprite, open, false) == Layout::moving);
    CHECK(layout(sprite, open, true) == Layout::deep_moving);
  }
  for (const Sprite& sprite : {smoke, sphere}) CHECK(layout(sprite, view, false) == Layout::deep);
  for (const Sprite& sprite : {in_metres, large, narrow, broad}) {
    CHECK(layout(sprite, view, false) == Layout::sized);
    CHECK(layout(sprite, view, true) == Layout::deep_sized);
    CHECK(layout(sprite, small_view(8000, view.height), false) == Layout::wide);
  }
  CHECK(layout(part, view, false) == Layout::plain);
  CHECK(layout(leaf, view, false) == Layout::wide && layout(leaf, open, false) == Layout::wide);
  CHECK(!anything_hides(view, std::vector<Sprite>{disc, sphere}));
  CHECK(anything_hides(view, std::vector<Sprite>{disc, smoke}) && anything_hides(with_object(view), {}));
}

}  // namespace motes::test_image_records
