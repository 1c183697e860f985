// Sprites of any size, streaks and images.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "check.h"
#include "image/camera.h"
#include "test_image_painter_scene.h"

using namespace image_test;
using Blend = Sprite::Blend;
using Kind = Sprite::Kind;

namespace {

constexpr double kPi = 3.14159265358979323846;

Sprite wide_sprite(Kind kind, Blend blend, AssetKey picture = 0) {
  Sprite s;
  s.kind = kind;
  s.blend = blend;
  s.pixels = kind == Kind::point ? 1 : 0;
  s.picture = picture;
  return s;
}

// At (x, y) pixels from the centre of the image.
WideRecord wide_record(double x, double y, double diameter, double depth = 10) {
  WideRecord r{};
  r.x = static_cast<std::int32_t>(std::lround(x * 256));
  r.y = static_cast<std::int32_t>(std::lround(y * 256));
  for (auto& c : r.color) c = 255;
  r.alpha = 255;
  const auto z = static_cast<float>(depth);
  std::memcpy(&r.depth, &z, 4);
  r.size = static_cast<std::uint16_t>(std::lround(diameter * 64));
  r.light = kAllLight;
  return r;
}

View wide_view(int width, int height) {
  View view = small_view(width, height);
  view.background = {0, 0, 0};
  return view;
}

// All tiles of a picture, rows from top to bottom.
std::vector<float> whole_picture(const View& view, const std::vector<Piece>& pieces) {
  const auto row = static_cast<std::size_t>(3 * view.width);
  std::vector<std::uint32_t> light(row * static_cast<std::size_t>(view.height));
  PreparedScene scene;
  scene.prepare(view);
  scene.render_all();
  TilePainter painter;
  painter.begin(scene);
  for (int tile = 0; tile < scene.grid().tiles(); ++tile) {
    const Area area = scene.grid().area(tile);
    painter.start(area);
    painter.paint(pieces);
    painter.sums(light.data() + 3 * (area.y * view.width + area.x), row);
  }
  return linear_of(light);
}

std::vector<float> picture_of(const View& view, const Sprite& sprite, const WideRecord& record) {
  Batch one(sprite, Layout::wide, view);
  one.put(record);
  return whole_picture(view, {one.piece()});
}

double sum(const std::vector<float>& light) { return std::accumulate(light.begin(), light.end(), 0.0); }

// Opaque, 16x8: the upper half red, the lower half green, half transparent.
AssetKey two_colors() {
  Picture p;
  p.width = 16;
  p.height = 8;
  for (int i = 0; i < 128; ++i) {
    const bool upper = i < 64;
    for (const int c : {upper ? 255 : 0, upper ? 0 : 255, 0, upper ? 255 : 128}) {
      p.rgba.push_back(static_cast<std::uint8_t>(c));
    }
  }
  return keep(p);
}

std::vector<const WideLanes*> usable_wide_lanes() {
  std::vector<const WideLanes*> all{&motes::sse2::wide_lanes};
  const std::size_t builds = usable_splat_lanes().size();
  if (builds > 1) all.push_back(&motes::avx2::wide_lanes);
  if (builds > 2) all.push_back(&motes::avx512::wide_lanes);
  return all;
}

Batch random_wide(const Sprite& sprite, const View& view, std::size_t count, std::uint64_t seed, bool streaks) {
  Batch batch(sprite, Layout::wide, view);
  test::Dice dice(seed);
  for (std::size_t i = 0; i < count; ++i) {
    WideRecord r = wide_record(dice.between(-0.6f, 0.6f) * static_cast<float>(view.width),
                               dice.between(-0.6f, 0.6f) * static_cast<float>(view.height),
                               i % 10 == 0 ? dice.between(20, 200) : dice.between(2, 20),
                               dice.coin() ? dice.between(5, 15) : 5 + static_cast<float>(dice.below(10)));
    for (auto& c : r.color) c = static_cast<std::uint8_t>(dice.below(256));
    r.alpha = static_cast<std::uint8_t>(dice.below(256));
    r.light = static_cast<std::uint16_t>(1 + dice.below(kAllLight));
    const float turn = dice.between(0, 6.28f);
    r.up_x = static_cast<std::int16_t>(32767 * std::cos(turn));
    r.up_y = static_cast<std::int16_t>(32767 * std::sin(turn));
    if (streaks && dice.coin()) {
      r.dx = static_cast<std::int32_t>(dice.between(-60, 60) * 256);
      r.dy = dice.coin() ? 0 : static_cast<std::int32_t>(dice.between(-60, 60) * 256);
    }
    batch.put(r);
  }
  return batch;
}

// A streak of a sprite of one size, which may have a stamp. Places and half ways are in 1/16 px.
void put_streak(Batch& batch, int x, int y, int half_x, int half_y) {
  const Sprite& sprite = batch.brush.sprite();
  const std::int16_t place[] = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
  const std::int16_t way[] = {static_cast<std::int16_t>(half_x), static_cast<std::int16_t>(half_y)};
  const std::uint16_t size[] = {static_cast<std::uint16_t>(64 * (sprite.pixels == 1 ? 2 : sprite.pixels)), kAllLight};
  std::byte bytes[16];
  std::memset(bytes, 0xff, sizeof bytes);
  std::memcpy(bytes, place, 4);
  std::memcpy(bytes + 8, size, 4);
  std::memcpy(bytes + 12, way, 4);
  batch.bytes.insert(batch.bytes.end(), bytes, bytes + sizeof bytes);
}

std::vector<Batch> every_kind(const View& view, std::uint64_t seed) {
  std::vector<Batch> batches;
  for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere, Kind::image}) {
    for (const Blend blend : {Blend::add, Blend::alpha, Blend::opaque}) {
      Sprite sprite = wide_sprite(kind, blend, kind == Kind::image ? two_colors() : 0);
      if (kind == Kind::disc) sprite.softness = 0.5f;
      batches.push_back(random_wide(sprite, view, blend == Blend::opaque ? 8 : 40, ++seed, true));
    }
  }
  return batches;
}

}  // namespace

TEST(image_wide_discs_look_like_footprints) {
  const View view = wide_view(64, 64);
  for (int pixels = 2; pixels <= 15; ++pixels) {
    Sprite fixed;
    fixed.pixels = pixels;
    for (int step = 0; step < 5; ++step) {
      // Footprints know few positions: take one of them.
      const double at = step * 0.25 + 0.125 + (pixels > 7 ? 0 : -0.0625) + 1.0 / 32;
      Batch small(fixed, Layout::deep, view);
      const DeepRecord r{static_cast<std::int16_t>(std::floor(at * 16)),
                         static_cast<std::int16_t>(std::floor(at * 16)),
                         {255, 255, 255},
                         255,
                         0x41200000};
      small.put(r);
      const auto expected = whole_picture(view, {small.piece()});
      const auto light = picture_of(view, wide_sprite(Kind::disc, Blend::add), wide_record(at, at, pixels));
      CHECK_NEAR(sum(light) / sum(expected), 1, 0.01);
      for (std::size_t i = 0; i < light.size(); ++i) CHECK_NEAR(light[i], expected[i], 0.07);
    }
  }
}

TEST(image_a_streak_has_the_light_of_the_still_sprite) {
  const View view = wide_view(200, 200);
  for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere, Kind::image}) {
    const Sprite sprite = wide_sprite(kind, Blend::add, kind == Kind::image ? two_colors() : 0);
    for (const double diameter : {2.0, 2.5, 3.3, 5.0, 9.0, 30.0}) {
      if (kind == Kind::point && diameter > 2) continue;
      double still = 0;
      for (int i = 0; i < 16; ++i) {
        still += sum(picture_of(view, sprite, wide_record(0.25 * (i % 4), 0.25 * (i / 4), diameter))) / 16;
      }
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

// The same particle in the layout that has a size or a way, with or without depth.
TEST(image_short_records_look_like_wide_ones) {
  const View view = painter_view(true);
  test::Dice dice(77);
  const Grid grid{view.width, view.height};
  const int unit = 1 << (8 - grid.far_bits());
  for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere}) {
    for (const Blend blend : {Blend::add, Blend::alpha, Blend::opaque}) {
      for (const Layout layout : {Layout::sized, Layout::deep_sized, Layout::moving, Layout::deep_moving}) {
        const RecordForm f = form(layout);
        if (kind == Kind::point && f.way != 0) continue;  // points are of one size: see the next test
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
        // Without a depth, records are in the order of other bytes.
        if (f.depth != 0 || blend != Blend::alpha) CHECK(whole_picture(view, {narrow.piece()}) == light);
      }
    }
  }
}

// Their places and lengths are rounded, and their weights are kept from record to record.
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
      const int reach = i % 4 == 0 ? 40 : 12;  // px, half of the way; the long ones have no stamps
      const auto way = [&] { return (static_cast<int>(dice.below(33)) - 16) * reach; };
      const auto place = [&] { return static_cast<int>(dice.below(400)) - 200; };
      const int numbers[] = {place(), place(), way(), way()};
      Batch one(sprite, Layout::moving, view);
      put_streak(one, numbers[0], numbers[1], numbers[2], numbers[3]);
      CHECK_NEAR(sum(whole_picture(view, {one.piece()})) / expected, 1, 0.01);
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

// Stamps are for 16 places in a pixel, in the middle of its quarters: there they are what is drawn without them.
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
        CHECK_NEAR(off / most, 0, 0.01);
      }
    }
  }
}

// Ways of (8, 2) and (-8, 18) px share a place among the stamps: each replaces the other's while records of both are
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

TEST(image_points_keep_their_light_when_they_move) {
  const View view = wide_view(64, 64);
  Sprite point;
  point.kind = Kind::point;
  Batch fixed(point, Layout::plain, view);
  fixed.put(PlainRecord{3, 5, {255, 255, 255}, 255});
  const double still = sum(whole_picture(view, {fixed.piece()}));
  WideRecord r = wide_record(0.2, 0.3, 2);
  r.dx = 2000;
  r.dy = 700;
  CHECK_NEAR(sum(picture_of(view, wide_sprite(Kind::point, Blend::add), r)) / still, 1, 0.01);
}

TEST(image_a_streak_is_as_long_and_wide_as_it_should_be) {
  const View view = wide_view(100, 60);
  WideRecord r = wide_record(0, 0, 6);
  r.dx = 40 * 256;
  const auto light = picture_of(view, wide_sprite(Kind::disc, Blend::add), r);
  const auto at = [&](int x, int y) { return light[static_cast<std::size_t>(3 * (y * view.width + x))]; };
  CHECK(at(50, 30) > 0 && at(72, 29) > 0 && at(27, 30) > 0);
  CHECK(at(74, 30) == 0 && at(25, 30) == 0 && at(50, 34) == 0 && at(50, 25) == 0);
  CHECK_NEAR(at(50, 30), at(40, 29), 1e-5);  // even along its way
}

TEST(image_opaque_sprites_keep_their_size) {
  const View view = wide_view(600, 560);
  for (const Kind kind : {Kind::disc, Kind::sphere}) {
    for (const double diameter : {2.0, 4.5, 17.0, 100.25, 512.0}) {
      Batch one(wide_sprite(kind, Blend::opaque), Layout::wide, view);
      one.put(wide_record(0.3, 0.1, diameter));
      const auto light = whole_picture(view, {one.piece()});
      double covered = 0;
      for (std::size_t i = 0; i < light.size(); i += 3) covered += light[i] > 0 ? 1 : 0;
      const double measured = 2 * std::sqrt(covered / kPi);
      CHECK_NEAR(measured, diameter, 0.5);
    }
  }
}

TEST(image_a_large_sphere_is_round_in_depth) {
  View view = wide_view(128, 128);
  view.camera.fov_deg = 2;
  const double focal = lens(view).focal_px;
  for (const double diameter : {20.0, 60.0, 110.0}) {
    Batch one(wide_sprite(Kind::sphere, Blend::opaque), Layout::wide, view);
    one.put(wide_record(0.4, -0.7, diameter));
    const double radius = 0.5 * diameter / focal * 10, cx = 0.4 / focal * 10, cy = -0.7 / focal * 10;
    double worst = 0;
    for (int tile = 0; tile < 4; ++tile) {
      PaintedTile painted(view, tile);
      painted.paint({one.piece()});
      const auto depth = painted.depth();
      for (int y = 0; y < painted.area.height; ++y) {
        for (int x = 0; x < painted.area.width; ++x) {
          const double dx = (painted.area.x + x + 0.5 - 64) / focal, dy = (painted.area.y + y + 0.5 - 64) / focal;
          const double dd = dx * dx + dy * dy + 1, dc = dx * cx + dy * cy + 10;
          const double under = dc * dc - dd * (cx * cx + cy * cy + 100 - radius * radius);
          if (under < 0.05 * radius * radius * dd) continue;
          const double seen = depth[static_cast<std::size_t>(y * painted.area.width + x)];
          worst = std::max(worst, std::fabs(seen - (dc - std::sqrt(under)) / dd) / radius);
        }
      }
    }
    CHECK(worst < 0.02);
  }
}

TEST(image_pictures_are_turned_by_up) {
  const View view = wide_view(64, 64);
  const Sprite sprite = wide_sprite(Kind::image, Blend::alpha, two_colors());
  const auto colors = [&](double up_x, double up_y) {
    WideRecord r = wide_record(0, 0, 32);
    r.up_x = static_cast<std::int16_t>(32767 * up_x);
    r.up_y = static_cast<std::int16_t>(32767 * up_y);
    return picture_of(view, sprite, r);
  };
  const auto at = [&](const std::vector<float>& light, int x, int y, std::size_t c) {
    return light[static_cast<std::size_t>(3 * (y * 64 + x)) + c];
  };
  for (const auto& [x, y] : {std::pair{0.0, -1.0}, {0.0, 0.0}}) {  // unknown: upright
    const auto upright = colors(x, y);
    CHECK_NEAR(at(upright, 32, 27, 0), 1, 0.01);
    CHECK_NEAR(at(upright, 32, 36, 1), 128 / 255.0, 0.01);
    CHECK(at(upright, 32, 27, 1) == 0 && at(upright, 32, 36, 0) == 0);
    CHECK(at(upright, 20, 27, 0) > 0.9 && at(upright, 32, 20, 0) == 0);  // twice as wide as high
  }
  const auto right = colors(1, 0);
  CHECK_NEAR(at(right, 36, 32, 0), 1, 0.01);
  CHECK_NEAR(at(right, 27, 32, 1), 128 / 255.0, 0.01);
  const auto down = colors(0, 1);
  CHECK_NEAR(at(down, 32, 36, 0), 1, 0.01);
}

TEST(image_small_pictures_are_means_of_large_ones) {
  const View view = wide_view(64, 64);
  const Sprite sprite = wide_sprite(Kind::image, Blend::add, two_colors());
  for (const double size : {3.0, 6.0, 16.0, 50.0}) {
    double red = 0, green = 0;
    for (int i = 0; i < 16; ++i) {
      const auto light = picture_of(view, sprite, wide_record(0.25 * (i % 4), 0.25 * (i / 4), size));
      for (std::size_t p = 0; p < light.size(); p += 3) {
        red += light[p] / 16;
        green += light[p + 1] / 16;
      }
    }
    CHECK_NEAR(red / (size * size / 4), 1, 0.03);
    CHECK_NEAR(green / (size * size / 4 * 128 / 255), 1, 0.03);
  }
}

TEST(image_wide_sprites_do_not_depend_on_order_pieces_or_isa) {
  for (const bool solid : {false, true}) {
    const View view = painter_view(solid);
    std::vector<Batch> batches = every_kind(view, 50);
    for (int tile = 0; tile < 4; ++tile) {
      std::vector<Piece> pieces;
      for (const Batch& b : batches) pieces.push_back(b.piece());
      PaintedTile painted(view, tile);
      const auto reference = painted.paint(pieces);
      const auto depths = painted.depth();
      CHECK(*std::max_element(reference.begin(), reference.end()) > 0.1);
      test::Dice dice(8);
      const auto splats = usable_splat_lanes();
      const auto wides = usable_wide_lanes();
      for (std::size_t isa = 0; isa < splats.size(); ++isa) {
        pieces = shuffled_pieces(batches, dice);
        PaintedTile other(view, tile, *splats[isa], *wides[isa]);
        CHECK(other.paint(pieces) == reference);
        CHECK(other.depth() == depths);
      }
      // Opaque ones by way of partial tiles.
      PaintedTile first(view, tile), second(view, tile), owner(view, tile);
      std::vector<Piece> one, two, rest;
      for (const Batch& b : batches) {
        if (b.brush.blends(Blend::opaque)) {
          one.push_back(b.piece(0, 3));
          two.push_back(b.piece(3));
        } else {
          rest.push_back(b.piece());
        }
      }
      owner.painter.merge(second.partial(two));
      owner.painter.merge(first.partial(one));
      CHECK(owner.paint(rest) == reference);
    }
  }
}

// A golden digest: all compilers, optimisation levels and machines must agree on it.
TEST(image_blends_are_the_same_everywhere) {
  const View view = painter_view();  // scenery has digests of its own
  const std::vector<Batch> batches = every_kind(view, 3);
  std::vector<Piece> pieces;
  for (const Batch& b : batches) pieces.push_back(b.piece());
  std::uint64_t digest = 0xcbf29ce484222325u;  // FNV-1a
  for (const float light : whole_picture(view, pieces)) {
    std::uint32_t bits;
    std::memcpy(&bits, &light, 4);
    digest = (digest ^ bits) * 0x100000001b3u;
  }
  constexpr std::uint64_t kGolden = 0x6af7c7b8d4f5850u;
  CHECK(digest == kGolden);
  if (digest != kGolden) std::printf("digest %#llx\n", static_cast<unsigned long long>(digest));
}

TEST(image_wide_records_at_the_limits_stay_inside_the_tile) {
  const View view = wide_view(100, 100);
  for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere, Kind::image}) {
    for (const Blend blend : {Blend::add, Blend::alpha, Blend::opaque}) {
      Batch batch(wide_sprite(kind, blend, kind == Kind::image ? two_colors() : 0), Layout::wide, view);
      for (const int x : {-(1 << 22), -12800, 0, 12799, (1 << 22)}) {
        for (const int dx : {-(1 << 23), 0, 1, (1 << 23)}) {
          for (const int size : {128, 512 * 64}) {
            WideRecord r = wide_record(0, 0, 2);
            r.x = x;
            r.y = -x / 3;
            r.dx = dx;
            r.dy = dx / 7;
            r.size = static_cast<std::uint16_t>(size);
            batch.put(r);
          }
        }
      }
      const auto light = whole_picture(view, {batch.piece()});  // the sanitizers look at the rest
      CHECK(*std::max_element(light.begin(), light.end()) > 0);
    }
  }
}
