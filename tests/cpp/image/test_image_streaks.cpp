// Sprites that move while the shutter is open.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "image/test_image_wide_scene.h"
#include "support/check.h"

namespace motes::test_image_streaks {
using namespace image_test;

namespace {

// Adds a streak of a sprite of one size, which may have a stamp. Positions and half lengths are in 1/16 px.
void put_streak(Batch& batch, int x, int y, int half_x, int half_y, std::uint32_t color = ~0u) {
  const Sprite& sprite = batch.brush.sprite();
  const std::int16_t place[] = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
  const std::int16_t way[] = {static_cast<std::int16_t>(half_x), static_cast<std::int16_t>(half_y)};
  const std::uint16_t size[] = {static_cast<std::uint16_t>(64 * (sprite.pixels == 1 ? 2 : sprite.pixels)), kAllLight};
  std::array<std::byte, 16> record;
  record.fill(std::byte{0xff});
  std::memcpy(record.data(), place, 4);
  std::memcpy(record.data() + 4, &color, 4);
  std::memcpy(record.data() + 8, size, 4);
  std::memcpy(record.data() + 12, way, 4);
  batch.put(record);
}

// Returns the light of a sprite without a streak, the mean over its positions in a pixel.
double still_light(const View& view, const Sprite& sprite, double diameter) {
  double light = 0;
  for (int i = 0; i < 16; ++i) {
    light += sum(picture_of(view, sprite, wide_record(0.25 * (i % 4), 0.25 * (i / 4), diameter))) / 16;
  }
  return light;
}

}  // namespace

TEST(image_a_streak_has_the_light_of_the_still_sprite) {
  const View view = wide_view(200, 200);
  for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere, Kind::image}) {
    const Sprite sprite = wide_sprite(kind, Blend::add, kind == Kind::image ? two_colors() : 0);
    for (const double diameter : {2.0, 2.5, 3.3, 5.0, 9.0, 30.0}) {
      if (kind == Kind::point && diameter > 2) continue;
      const double still = still_light(view, sprite, diameter);
      for (const auto& [dx, dy] :
           {std::pair{0.02, 0.01}, {1.0, 0.0}, {0.0, 3.0}, {10.0, 0.0}, {7.0, -7.0}, {3.0, 40.0}, {-60.0, 25.0}}) {
        for (const double shift : {0.0, 0.37, 0.5}) {
          WideRecord r = wide_record(shift, 1.3 * shift, diameter);
          r.dx = static_cast<std::int32_t>(dx * 256);
          r.dy = static_cast<std::int32_t>(dy * 256);
          const double moving = sum(picture_of(view, sprite, r));
          CHECK_NEAR(moving / still, 1, 0.01);
        }
      }
    }
  }
}

// A view of so narrow an angle that spheres of any size are seen from the same direction.
View far_view(int width, int height) {
  View view = wide_view(width, height);
  view.camera.fov_deg = 1;
  return view;
}

// Narrow streaks along a row or a column lie between its pixels, or do not, for their whole length.
TEST(image_a_streak_across_all_of_a_large_picture_keeps_its_light) {
  for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere, Kind::image}) {
    const Sprite sprite = wide_sprite(kind, Blend::add, kind == Kind::image ? two_colors() : 0);
    for (const double diameter : {2.0, 3.3, 9.0}) {
      if (kind == Kind::point && diameter > 2) continue;
      const double still = still_light(far_view(64, 64), sprite, diameter);
      for (const double length : {1000.0, 1100.0, 3000.0}) {
        for (const double aside : {0.0, 0.3, -2.6, 11.7, 45.0}) {
          for (const double shift : {0.0, 0.5}) {
            if (shift > 0 && diameter != 3.3) continue;
            const bool coarse = kind == Kind::image && diameter < 3 && length > 1024;  // texels are far apart
            WideRecord r = wide_record(shift, shift, diameter);
            r.dx = static_cast<std::int32_t>(length * 256);
            r.dy = static_cast<std::int32_t>(aside * 256);
            CHECK_NEAR(sum(picture_of(far_view(3200, 128), sprite, r)) / still, 1, coarse ? 0.1 : 0.01);
            const int across = r.dx;
            r.dx = r.dy;
            r.dy = across;
            CHECK_NEAR(sum(picture_of(far_view(128, 3200), sprite, r)) / still, 1, coarse ? 0.1 : 0.01);
          }
        }
      }
    }
  }
}

// The same particle in layouts with a size or a streak, with or without depth.
TEST(image_short_records_look_like_wide_ones) {
  const View view = painter_view(true);
  test::Dice dice(77);
  const Grid grid{view.width, view.height};
  const int unit = 1 << (8 - grid.far_bits());
  for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere}) {
    for (const Blend blend : {Blend::add, Blend::alpha, Blend::opaque}) {
      for (const Layout layout : {Layout::sized, Layout::deep_sized, Layout::moving, Layout::deep_moving}) {
        const RecordForm f = form(layout);
        if (kind == Kind::point && f.way != 0) continue;  // points have one size: see the next test
        const Sprite sprite = wide_sprite(kind, blend);
        Batch wide(sprite, Layout::wide, view), narrow(sprite, layout, view);
        for (int i = 0; i < 30; ++i) {
          WideRecord r = wide_record(0, 0, dice.between(2, 40), dice.between(5, 15));
          r.x = unit * (static_cast<int>(dice.below(400)) - 200) * 8;
          r.y = unit * (static_cast<int>(dice.below(400)) - 200) * 8;
          r.light = static_cast<std::uint16_t>(1 + dice.below(kAllLight));
          if (f.depth == 0) r.depth = 0;
          if (f.way != 0) r.dx = 2 * unit * (static_cast<int>(dice.below(300)) - 150);
          if (f.way != 0) r.dy = 2 * unit * (static_cast<int>(dice.below(300)) - 150);
          wide.put(r);
          std::byte bytes[20];
          const auto pair = [&](int at, int x, int y) {
            const std::int16_t both[] = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
            std::memcpy(bytes + at, both, 4);
          };
          pair(0, r.x / unit, r.y / unit);
          std::memcpy(bytes + 4, r.color, 4);
          if (f.depth != 0) std::memcpy(bytes + f.depth, &r.depth, 4);
          std::memcpy(bytes + f.size, &r.size, 4);
          if (f.way != 0) pair(f.way, r.dx / unit / 2, r.dy / unit / 2);
          narrow.bytes.insert(narrow.bytes.end(), bytes, bytes + f.bytes);
        }
        const auto light = whole_picture(view, {wide.piece()});
        CHECK(*std::max_element(light.begin(), light.end()) > 0.01);
        // Without a depth, records are sorted by other bytes.
        if (f.depth != 0 || blend != Blend::alpha) CHECK(whole_picture(view, {narrow.piece()}) == light);
      }
    }
  }
}

// Positions and lengths are rounded, and weights are kept from record to record.
TEST(image_streaks_of_one_size_keep_their_light_in_any_order) {
  const View view = painter_view();
  for (const int pixels : {1, 2, 3, 5, 9, 15}) {
    Sprite sprite;
    sprite.pixels = pixels;
    Batch still(sprite, Layout::plain, view);
    still.put(PlainRecord{3, 5, {255, 255, 255}, 255});
    const double expected = sum(whole_picture(view, {still.piece()}));
    Batch all(sprite, Layout::moving, view);
    test::Dice dice(static_cast<std::uint64_t>(pixels));
    for (int i = 0; i < 60; ++i) {
      const int reach = i % 4 == 0 ? 40 : 16;  // px, half of the length; the long ones have no stamps
      const auto way = [&] { return (static_cast<int>(dice.below(33)) - 16) * reach; };
      const auto place = [&] { return static_cast<int>(dice.below(400)) - 200; };
      const int numbers[] = {place(), place(), way(), way()};
      Batch one(sprite, Layout::moving, view);
      put_streak(one, numbers[0], numbers[1], numbers[2], numbers[3]);
      CHECK_NEAR(sum(whole_picture(view, {one.piece()})) / expected, 1, i % 4 == 0 ? 0.01 : 0.001);
      put_streak(all, numbers[0], numbers[1], numbers[2], numbers[3]);
    }
    const auto splats = usable_splat_lanes();
    const auto wides = usable_wide_lanes();
    for (int tile = 0; tile < 4; ++tile) {
      PaintedTile painted(view, tile);
      const auto reference = painted.paint({all.piece()});
      test::Dice order(9);
      for (std::size_t isa = 0; isa < splats.size(); ++isa) {
        all.shuffle(order);
        PaintedTile other(view, tile, *splats[isa], *wides[isa]);
        CHECK(other.paint({all.piece(20), all.piece(0, 20)}) == reference);
      }
    }
  }
}

// Stamps exist for 16 positions in a pixel, the centres of a 4 x 4 grid. There they equal what is drawn without them,
// up to one step of a weight.
TEST(image_a_stamp_is_the_streak_at_its_place) {
  const View view = wide_view(64, 64);
  for (const int pixels : {2, 3, 5, 9}) {
    Sprite sprite;
    sprite.pixels = pixels;
    for (int quarter = 0; quarter < 16; ++quarter) {
      const int x = 16 * (quarter - 8) + 4 * (quarter % 4) + 2, y = 16 * (5 - quarter) + 4 * (quarter / 4) + 2;
      for (const auto& [dx, dy] : {std::pair{4, 0}, {0, 6}, {5, -3}, {-8, 2}, {1, 1}}) {  // px
        Batch stamped(sprite, Layout::moving, view);
        put_streak(stamped, x, y, 8 * dx, 8 * dy);
        const auto light = whole_picture(view, {stamped.piece()});
        WideRecord r = wide_record(x / 16.0, y / 16.0, pixels);
        r.dx = 256 * dx;
        r.dy = 256 * dy;
        const auto expected = picture_of(view, wide_sprite(Kind::disc, Blend::add), r);
        const double most = *std::max_element(expected.begin(), expected.end());
        double off = 0;
        for (std::size_t i = 0; i < light.size(); ++i) off = std::max(off, std::fabs(double{light[i]} - expected[i]));
        CHECK(most > 0);
        CHECK_NEAR(255 * off, 0, 1.1);
      }
    }
  }
}

// Many records of one colour are added up before they become light; a black one after each hundred of them leaves no
// run long enough for that. Both give the same sums to the last bit, also where sums are clipped.
TEST(image_streaks_of_one_color_are_added_up_to_the_same_sums) {
  const View view = painter_view();
  Sprite sprite;
  sprite.pixels = 5;
  for (const int count : {700, 6900, 20000}) {
    const bool bright = count > 700;
    const int spread = bright ? 4 : 900, longest = bright ? 2 : 96;
    Batch alike(sprite, Layout::moving, view), black(sprite, Layout::moving, view);
    put_streak(black, 0, 0, 16, 16, 0xff000000u);
    test::Dice dice(5);
    const auto some = [&](int range) {
      return static_cast<int>(dice.below(static_cast<std::uint64_t>(range))) - range / 2;
    };
    for (int i = 0; i < count; ++i)
      put_streak(alike, some(spread), some(spread), some(longest), some(longest), bright ? ~0u : 0xf0b08040u);
    Batch discs(sprite, Layout::plain, view);
    for (int i = 0; i < 300; ++i) discs.put(PlainRecord{0, 0, {255, 255, 255}, 255});
    std::vector<Piece> short_runs;
    for (std::size_t i = 0; i < alike.count(); i += 100) {
      short_runs.push_back(alike.piece(i, 100));
      short_runs.push_back(black.piece());
    }
    short_runs.push_back(discs.piece());
    const auto wides = usable_wide_lanes();
    for (int tile = 0; tile < 4; ++tile) {
      PaintedTile one(view, tile);
      const auto reference = one.paint(short_runs);
      for (std::size_t isa = 0; isa < wides.size(); ++isa) {
        PaintedTile other(view, tile, *usable_splat_lanes()[isa], *wides[isa]);
        CHECK(other.paint({alike.piece(), discs.piece()}) == reference);
        other.painter.start(other.area);
        CHECK(other.paint({alike.piece(0, 300), alike.piece(300), discs.piece()}) == reference);
      }
    }
  }
}

// Some of these reach far beside their tiles. A tile with an odd number of rows is followed by one that has more.
TEST(image_streaks_at_the_edges_of_tiles_are_added_up_to_the_same_sums) {
  const View view = small_view(120, 91);
  Sprite sprite;
  sprite.pixels = 15;
  Batch alike(sprite, Layout::moving, view), black(sprite, Layout::moving, view);
  put_streak(black, 0, 0, 16, 16, 0xff000000u);
  test::Dice dice(8);
  const auto some = [&](int range) {
    return static_cast<int>(dice.below(static_cast<std::uint64_t>(range))) - range / 2;
  };
  for (int i = 0; i < 5000; ++i) put_streak(alike, 64 + some(240), 296 + some(240), some(256), some(256), 0x10ffffffu);
  std::vector<Piece> short_runs;
  for (std::size_t i = 0; i < alike.count(); i += 100) {
    short_runs.push_back(alike.piece(i, 100));
    short_runs.push_back(black.piece());
  }
  const auto wides = usable_wide_lanes();
  for (std::size_t isa = 0; isa < wides.size(); ++isa) {
    PaintedTile one(view, 2, *usable_splat_lanes()[isa], *wides[isa]);
    for (const int tile : {2, 0, 3, 1}) {
      one.scene.render(tile);
      one.area = one.scene.grid().area(tile);
      one.painter.start(one.area);
      CHECK(one.paint({alike.piece()}) == PaintedTile(view, tile).paint(short_runs));
    }
  }
}

// Both are 2 px wide, but a point shines more.
TEST(image_points_and_discs_of_their_size_do_not_share_stamps) {
  View view = wide_view(128, 128);
  view.shutter = 1;
  const Cloud cloud = random_cloud(50, 6, false);
  Drawn drawn = cloud.drawn();
  drawn.velocity_of_all = {0.3f, 0.1f, 0};
  Projection moving;
  moving.dt = 1;
  const auto of = [&](Kind kind, int pixels) { return projected(drawn, {kind, pixels}, view, moving); };
  const auto points = of(Kind::point, 1), discs = of(Kind::disc, 2);
  CHECK(picture(view, {points, discs}) == picture(view, {discs, points}));
  CHECK(picture(view, {points}) != picture(view, {discs}));
}

TEST(image_what_is_drawn_as_a_point_looks_like_one_at_rest_and_in_motion) {
  View view = wide_view(128, 128);
  const Cloud cloud = random_cloud(50, 7, false);
  for (const float shutter : {0.0f, 1.0f}) {
    view.shutter = shutter;
    for (const float speed : {0.0f, 0.4f}) {
      Drawn drawn = cloud.drawn();
      drawn.velocity_of_all = {speed, -speed, 0};
      for (const Blend blend : {Blend::add, Blend::alpha, Blend::opaque}) {
        Projection how;
        how.dt = 1;
        how.any_depth = blend != Blend::add;
        const auto of = [&](Kind kind) { return picture(view, {projected(drawn, {kind, 1, blend}, view, how)}); };
        CHECK(of(Kind::disc) == of(Kind::point));
        CHECK(of(Kind::sphere) == of(Kind::point));
      }
    }
  }
}

// Streaks of (8, 2) and (-8, 18) px share a slot for stamps: each replaces the other's stamp while records of both are
// drawn.
TEST(image_stamps_that_share_a_place_are_not_mistaken_for_each_other) {
  const View view = wide_view(64, 64);
  Sprite sprite;
  sprite.pixels = 5;
  Batch both(sprite, Layout::moving, view), first(sprite, Layout::moving, view), second(sprite, Layout::moving, view);
  for (int i = 0; i < 30; ++i) {
    const bool odd = i % 2 != 0;
    for (Batch* batch : {&both, odd ? &second : &first}) {
      put_streak(*batch, 64 * (i % 6) - 160, 16 * i - 240, odd ? -64 : 64, odd ? 144 : 16);
    }
  }
  const auto together = whole_picture(view, {both.piece()});
  const auto one = whole_picture(view, {first.piece()}), other = whole_picture(view, {second.piece()});
  for (std::size_t i = 0; i < together.size(); ++i) CHECK_NEAR(together[i], one[i] + other[i], 1e-5);
}

TEST(image_a_streak_is_as_long_and_wide_as_it_should_be) {
  const View view = wide_view(100, 60);
  WideRecord r = wide_record(0, 0, 6);
  r.dx = 40 * 256;
  const auto light = picture_of(view, wide_sprite(Kind::disc, Blend::add), r);
  const auto at = [&](int x, int y) { return light[static_cast<std::size_t>(3 * (y * view.width + x))]; };
  CHECK(at(50, 30) > 0 && at(72, 29) > 0 && at(27, 30) > 0);
  CHECK(at(74, 30) == 0 && at(25, 30) == 0 && at(50, 34) == 0 && at(50, 25) == 0);
  CHECK_NEAR(at(50, 30), at(40, 29), 1e-5);  // even along its length
}

}  // namespace motes::test_image_streaks
