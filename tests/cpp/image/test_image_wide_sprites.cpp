// Sprites of any size, and images.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "image/test_image_wide_scene.h"
#include "support/check.h"

namespace motes::test_image_wide_sprites {
using namespace image_test;

namespace {

constexpr double kPi = 3.14159265358979323846;

Batch random_wide(const Sprite& sprite, const View& view, std::size_t count, std::uint64_t seed, bool streaks) {
  Batch batch(sprite, Layout::wide, view);
  test::Dice dice(seed);
  for (std::size_t i = 0; i < count; ++i) {
    // Drawn one after another: compilers may compute arguments in any order.
    const float depth = dice.coin() ? dice.between(5, 15) : 5 + static_cast<float>(dice.below(10));
    const float diameter = i % 10 == 0 ? dice.between(20, 200) : dice.between(2, 20);
    const float y = dice.between(-0.6f, 0.6f) * static_cast<float>(view.height);
    const float x = dice.between(-0.6f, 0.6f) * static_cast<float>(view.width);
    WideRecord r = wide_record(x, y, diameter, depth);
    for (auto& c : r.color) c = static_cast<std::uint8_t>(dice.below(256));
    r.alpha = static_cast<std::uint8_t>(dice.below(256));
    r.light = static_cast<std::uint16_t>(1 + dice.below(kAllLight));
    const double turn = dice.between(0, 6.28f);
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
      // Footprints exist for few positions: take one of them.
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

// Pictures with any sides, shown at any scale.
TEST(image_pictures_are_where_and_as_large_as_they_should_be) {
  const View view = wide_view(64, 64);
  for (const auto& [width, height] :
       {std::pair{128, 128}, {129, 129}, {127, 63}, {65, 33}, {100, 1}, {3, 5}, {5, 3}, {1, 1}}) {
    meshes::Picture white;
    white.width = width;
    white.height = height;
    white.rgba.assign(static_cast<std::size_t>(4 * width * height), 255);
    const Sprite sprite = wide_sprite(Kind::image, Blend::add, meshes::keep(std::move(white)));
    const double longer = std::max(width, height);
    for (const double size : {2.0, 3.0, 5.0, 8.0, 20.0, 30.0}) {
      for (const double turn : {0.0, 0.6}) {
        WideRecord r = wide_record(0.3, -0.2, size);
        r.up_x = static_cast<std::int16_t>(32767 * std::sin(turn));
        r.up_y = static_cast<std::int16_t>(-32767 * std::cos(turn));
        const std::vector<float> light = picture_of(view, sprite, r);
        double all = 0, x = 0, y = 0, square = 0;
        for (std::size_t i = 0; i < light.size(); i += 3) {
          const double here_x = static_cast<double>(i / 3 % 64) - 31.8, here_y = static_cast<double>(i / 3 / 64) - 31.3;
          all += light[i];
          x += light[i] * here_x;
          y += light[i] * here_y;
          square += light[i] * (here_x * here_x + here_y * here_y);
        }
        const double least = size * std::min(width, height) / longer, place = least < 1 ? 0.5 : 0.2;
        CHECK_NEAR(x / all, 0, place);
        CHECK_NEAR(y / all, 0, place);
        // The mean square distance from the middle of a rectangle, plus that of a texel's and a pixel's edges.
        const double sides = size * size * (width * width + height * height) / (longer * longer) / 12;
        CHECK(square / all < sides + 0.9 && square / all > 0.8 * sides);
        CHECK_NEAR(all / (size * size * width * height / (longer * longer)), 1, 0.07);
      }
    }
  }
}

TEST(image_thin_pictures_do_not_flicker) {
  const View view = wide_view(64, 64);
  for (const auto& [width, height, size] : {std::tuple{9, 256, 22}, {5, 128, 22}, {9, 256, 42}, {3, 300, 30}}) {
    meshes::Picture white;
    white.width = width;
    white.height = height;
    white.rgba.assign(static_cast<std::size_t>(4 * width * height), 255);
    const Sprite sprite = wide_sprite(Kind::image, Blend::add, meshes::keep(std::move(white)));
    for (const double up : {-1.0, -0.8}) {
      for (int i = 0; i < 16; ++i) {
        WideRecord r = wide_record(0.125 * i, 0.3, size);
        r.up_x = static_cast<std::int16_t>(32767 * std::sqrt(1 - up * up));
        r.up_y = static_cast<std::int16_t>(32767 * up);
        const double light = sum(picture_of(view, sprite, r)) / 3;
        CHECK_NEAR(light / (static_cast<double>(size * size) * width / height), 1, up == -1 ? 0.02 : 0.08);
      }
    }
  }
}

// Images of up to 8 px are drawn from stamps: two pictures alternate, whose stamps share slots.
TEST(image_stamps_of_small_pictures_show_their_picture_and_its_direction) {
  const View view = wide_view(64, 64);
  const Sprite halves = wide_sprite(Kind::image, Blend::add, two_colors());
  const Sprite grey =
      wide_sprite(Kind::image, Blend::add, meshes::keep(meshes::Picture{16, 8, std::vector<std::uint8_t>(512, 200)}));
  for (int i = 0; i < 96; ++i) {
    const double turn = 0.0654 * i, x = 0.3 * (i % 7), y = -0.2 * (i % 9);
    WideRecord r = wide_record(x, y, 4 + 0.04 * i);
    r.up_x = static_cast<std::int16_t>(std::lround(32767 * std::sin(turn)));
    r.up_y = static_cast<std::int16_t>(std::lround(-32767 * std::cos(turn)));
    Batch first(halves, Layout::wide, view), second(grey, Layout::wide, view), again(halves, Layout::wide, view);
    for (Batch* batch : {&first, &second, &again}) batch->put(r);
    const auto colored = whole_picture(view, {first.piece()}), plain = whole_picture(view, {second.piece()});
    const auto all = whole_picture(view, {first.piece(), second.piece(), again.piece()});
    double red = 0, green = 0, across = 0, down = 0;
    for (std::size_t p = 0; p < all.size(); p += 3) {
      CHECK(plain[p] == plain[p + 1]);
      for (std::size_t c = p; c < p + 3; ++c) CHECK_NEAR(all[c], 2 * colored[c] + plain[c], 1e-3);
      red += colored[p];
      green += colored[p + 1];
    }
    for (std::size_t p = 0; p < all.size(); p += 3) {
      const double more = colored[p] / red - colored[p + 1] / green;
      across += more * static_cast<double>(p / 3 % 64);
      down += more * static_cast<double>(p / 3 / 64);
    }
    const double distance = std::hypot(across, down);
    CHECK((across * std::sin(turn) - down * std::cos(turn)) / distance > 0.97);
    CHECK(distance > 0.2 * (4 + 0.04 * i) && distance < 0.35 * (4 + 0.04 * i));
  }
}

// The same across the border of two tiles as within one; nearer records hide farther ones.
TEST(image_stamps_of_opaque_pictures_cover_their_area_in_their_colours) {
  const View view = wide_view(2 * kTile, kTile);
  meshes::Picture two{16, 8, std::vector<std::uint8_t>(512, 255)};
  for (std::size_t i = 0; i < 512; i += 4) two.rgba[i < 256 ? i + 1 : i] = two.rgba[i + 2] = 0;
  const Sprite halves = wide_sprite(Kind::image, Blend::opaque, meshes::keep(std::move(two)));
  const auto drawn = [&](WideRecord r, double turn, bool hidden) {
    r.up_x = static_cast<std::int16_t>(std::lround(32767 * std::sin(turn)));
    r.up_y = static_cast<std::int16_t>(std::lround(-32767 * std::cos(turn)));
    const std::uint8_t own[] = {200, 100, 50};
    std::copy_n(own, 3, r.color);
    Batch batch(halves, Layout::wide, view);
    batch.put(r);
    if (hidden) {
      const float farther = 11;
      std::memcpy(&r.depth, &farther, sizeof farther);
      r.color[0] = r.color[1] = 7;
      batch.put(r);
    }
    return whole_picture(view, {batch.piece()});
  };
  double covered = 0, expected = 0;
  for (int i = 0; i < 96; ++i) {
    const double turn = 0.0654 * i, size = 3 + 0.05 * i, y = -0.2 * (i % 9);
    const auto at_border = drawn(wide_record(0.3 * (i % 7), y, size), turn, false);
    const auto within = drawn(wide_record(0.3 * (i % 7) - 32, y, size), turn, true);
    for (std::size_t p = 0; p < at_border.size(); p += 3) {
      const double red = at_border[p], green = at_border[p + 1];
      if (p + 3 * 32 < at_border.size())
        CHECK(within[p] == at_border[p + 3 * 32] && within[p + 1] == at_border[p + 97]);
      if (red == 0 && green == 0) continue;
      covered += 1;
      CHECK_NEAR(red / (200.0 / 255) + green / (100.0 / 255), 1, 0.25);  // texels in the middle are mixed
    }
    expected += size * size / 2;
  }
  CHECK_NEAR(covered / expected, 1, 0.03);
}

TEST(image_stamps_of_opaque_pictures_are_others_than_those_of_light) {
  const View view = wide_view(64, 64);
  std::vector<Batch> batches;
  for (const Blend blend : {Blend::opaque, Blend::add, Blend::opaque}) {
    batches.emplace_back(wide_sprite(Kind::image, blend, two_colors()), Layout::wide, view);
    batches.back().put(wide_record(16.0 * static_cast<double>(batches.size()) - 32, 0, 6));
  }
  std::vector<float> sum(3 * 64 * 64);
  std::vector<Piece> pieces;
  for (const Batch& batch : batches) {
    pieces.push_back(batch.piece());
    const auto alone = whole_picture(view, {batch.piece()});
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += alone[i];
  }
  const auto all = whole_picture(view, pieces);
  for (std::size_t i = 0; i < sum.size(); ++i) CHECK_NEAR(all[i], sum[i], 1e-6);
}

// A picture of few texels, magnified: its edge must not be as wide as a texel, or neighbouring tiles would not see it.
TEST(image_magnified_pictures_have_sharp_edges_in_all_tiles) {
  const View view = wide_view(128, 128);
  meshes::Picture white;
  white.width = white.height = 2;
  white.rgba.assign(16, 255);
  Sprite sprite = wide_sprite(Kind::image, Blend::add, meshes::keep(std::move(white)));
  sprite.pixels = 40;
  const Cloud one(1);
  for (const float up : {0.0f, 1.0f}) {
    Drawn drawn = one.drawn();
    drawn.up_of_all = {up, 1, 0};
    const Projection plain;
    const std::vector<std::byte> records = projected(drawn, sprite, view, plain);
    Canvas canvas;
    canvas.begin(view, true);
    canvas.add(records);
    canvas.finish();
    const std::vector<float> light = canvas.linear();
    double all = 0;
    for (std::size_t i = 0; i < light.size(); i += 3) all += light[i];
    CHECK_NEAR(all / 1600, 1, 0.01);
    const auto at = [&](std::size_t x, std::size_t y) { return light[3 * (128 * y + x)]; };
    const std::size_t edge = up == 0 ? 20 : 28;  // px from the middle, to the right
    CHECK(at(64 + edge + 1, 64) == 0 && at(64 + edge - 2, 64) > 0.95F);
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
      // Opaque records go through partial tiles.
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
  constexpr std::uint64_t kGolden = 0x2e0151770e2fececu;
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
      const auto light = whole_picture(view, {batch.piece()});  // the sanitizers check the rest
      CHECK(*std::max_element(light.begin(), light.end()) > 0);
    }
  }
}

}  // namespace motes::test_image_wide_sprites
