#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "image/checks.h"
#include "image/curves.h"
#include "image/footprint.h"
#include "image/test_image_scene.h"
#include "image/tone.h"
#include "support/check.h"

namespace motes::test_image_canvas {
using namespace image_test;

namespace {

std::vector<float> linear_picture(const View& view, const std::vector<std::byte>& records) {
  Canvas canvas;
  canvas.begin(view, true);
  canvas.add(records);
  canvas.finish();
  return canvas.linear();
}

Solid sphere_at_origin(float radius) {
  Solid solid;
  solid.shape.kind = shapes::Kind::sphere;
  solid.shape.number[3] = radius;
  return solid;
}

}  // namespace

TEST(image_pixels_do_not_depend_on_order_grouping_or_isa) {
  const Cloud cloud = random_cloud(70000, 1);
  View solid = small_view(130, 100);
  solid.objects = {sphere_at_origin(2)};
  for (const View& view : {small_view(), solid}) {
    for (const Sprite& sprite : {Sprite{Sprite::Kind::point, 1}, Sprite{Sprite::Kind::disc, 2},
                                 Sprite{Sprite::Kind::disc, 5}, Sprite{Sprite::Kind::disc, 15}}) {
      const auto reference = picture(view, {message(cloud, sprite, view)});
      for (const std::size_t ranks : {2u, 3u, 7u}) {
        std::vector<std::vector<std::byte>> messages;
        for (std::size_t r = ranks; r-- > 0;) messages.push_back(message(every(cloud, r, ranks), sprite, view));
        CHECK(picture(view, messages) == reference);
      }
      for (const auto* lanes : usable_splat_lanes()) {
        CHECK(picture(view, {message(cloud, sprite, view)}, *lanes) == reference);
      }
    }
  }
}

// A golden digest: all compilers, optimisation levels and machines must agree on it.
TEST(image_pixels_are_the_same_everywhere) {
  View view = small_view(197, 131);
  Solid ground;
  ground.shape.kind = shapes::Kind::plane;
  ground.shape.number[1] = -2;
  ground.shape.number[4] = 1;
  view.objects = {sphere_at_origin(1), ground};
  view.camera.position = {1, 2, 9};
  std::uint64_t digest = 0xcbf29ce484222325u;  // FNV-1a
  const auto take = [&](const Pixels& pixels) {
    for (const std::uint8_t p : pixels) digest = (digest ^ p) * 0x100000001b3u;
  };
  take(picture(view, {message(random_cloud(5000, 2), {Sprite::Kind::disc, 5}, view)}));
  view.objects.clear();
  take(picture(view, {message(random_cloud(90000, 3), {Sprite::Kind::point, 1}, view)}));
  constexpr std::uint64_t kGolden = 0xec593e8a1f05f019u;
  CHECK(digest == kGolden);
  if (digest != kGolden) std::printf("digest %#llx\n", static_cast<unsigned long long>(digest));
}

TEST(image_crowded_tiles_saturate_the_same_by_either_path) {
  // 9000 particles of full light on one pixel overflow a sum; the plain path must notice.
  const View view = small_view(70, 70);
  for (const std::size_t count : {4000u, 4144u, 4145u, 9000u}) {
    const auto records = message(Cloud(count), {Sprite::Kind::disc, 3}, view);
    const RecordsView seen(records);
    const Brush brush({Sprite::Kind::disc, 3}, Layout::plain, view, seen.colored());
    Splat splat = brush.splat_at(0, 0);
    splat.color = seen.color();
    splat.saturating = true;
    const RecordsView::RecordRun piece = seen.piece(seen.batches()[0], 0);
    for (const auto* lanes : usable_splat_lanes()) {
      std::vector<std::uint32_t> light(kLightNumbers);
      const TilePlanes planes{light.data() + kFirstLight, nullptr, nullptr, false, 0, 0, nullptr};
      lanes->add(planes, splat, reinterpret_cast<const unsigned char*>(piece.records), piece.count);
      View dark = view;
      dark.background = {0, 0, 0};
      Canvas canvas(*lanes);
      canvas.begin(dark, true);
      canvas.add(records);
      canvas.finish();
      const auto linear = canvas.linear();
      bool same = true;
      for (std::size_t y = 0; y < 64; ++y) {
        for (std::size_t i = 0; i < 192; ++i) {
          same &= linear[y * 210 + i] == static_cast<float>(planes.light[y * kLightStride + i] / double{kUnit});
        }
      }
      CHECK(same);
      const double brightest = *std::max_element(linear.begin(), linear.end());
      CHECK(brightest <= static_cast<float>(4294967295.0 / kUnit));
      CHECK((count == 9000) == (brightest > 4144));
    }
  }
}

// Messages contain how faint their particles are, so that sums are not checked before they can overflow.
TEST(image_faint_crowds_saturate_no_sooner_and_no_later) {
  View dark = small_view(70, 70);
  dark.background = {0, 0, 0};
  const auto brightest = [&](const std::vector<Cloud>& clouds, const Sprite& sprite, const SplatLanes& lanes) {
    Canvas canvas(lanes);
    canvas.begin(dark, true);
    std::vector<std::vector<std::byte>> messages;
    for (const Cloud& cloud : clouds) messages.push_back(message(cloud, sprite, dark));
    for (const auto& records : messages) canvas.add(records);
    canvas.finish();
    const auto linear = canvas.linear();
    return *std::max_element(linear.begin(), linear.end());
  };
  Cloud faint(40000), own(40000, true), full(2000);
  faint.alpha_of_all = 0.0999f;  // 25.5 of 255, rounded to 25
  std::fill(own.alpha.begin(), own.alpha.end(), 0.0999f);
  CHECK(RecordsView(message(faint, {}, dark)).most_alpha() == 25);
  CHECK(RecordsView(message(own, {}, dark)).most_alpha() == 255);
  CHECK(RecordsView(message(full, {}, dark)).most_alpha() == 255);
  const auto greatest = static_cast<float>(4294967295.0 / kUnit);
  for (const auto* lanes : usable_splat_lanes()) {
    for (const Sprite& sprite : {Sprite{Sprite::Kind::disc, 3}, Sprite{Sprite::Kind::point, 1}}) {
      const float once = brightest({faint}, sprite, *lanes);
      CHECK(once == brightest({own}, sprite, *lanes) && once < greatest);
      CHECK(brightest({faint, full}, sprite, *lanes) == brightest({full, own}, sprite, *lanes));
    }
    // Particles are in the middle of pixels, so their whole weight of 255 is in one pixel.
    CHECK(brightest({faint, faint}, {Sprite::Kind::disc, 3}, *lanes) == greatest);
  }
}

// A colour above 1 makes records brighter than their alpha.
TEST(image_bright_crowds_saturate_no_sooner_and_no_later) {
  View dark = small_view(70, 70);
  dark.background = {0, 0, 0};
  constexpr std::size_t kCount = 9000;
  const Cloud places(kCount);
  const Sprite sprite{Sprite::Kind::disc, 3};
  const std::vector<float> red(kCount + 16, 9.0f), alpha(kCount + 16, 0.1f);
  Drawn bright = places.drawn();
  for (float& value : bright.color_of_all) value = 9;
  bright.alpha_of_all = 0.1f;
  Drawn own = bright, both = bright;
  for (const float*& plane : own.color) plane = red.data();
  both.alpha = alpha.data();
  const auto light_of = [&](const Drawn& drawn) {
    const auto records = projected(drawn, sprite, dark, {});
    Canvas canvas;
    canvas.begin(dark, true);
    canvas.add(records);
    canvas.finish();
    return canvas.linear();
  };
  const std::vector<float> wanted = light_of(both);
  CHECK(*std::max_element(wanted.begin(), wanted.end()) == static_cast<float>(4294967295.0 / kUnit));
  CHECK(light_of(bright) == wanted);
  CHECK(light_of(own) == wanted);
}

TEST(image_backgrounds_keep_their_light) {
  View view = small_view(8, 8);
  for (const float light : {1e-5f, 0.5f, 3.99f, 40.0f, 3000.0f, 1e6f}) {
    view.background = {light, 0, light / 4};
    const auto linear = linear_picture(view, message(Cloud(0), {Sprite::Kind::disc, 3}, view));
    const auto greatest = static_cast<float>(4294967295.0 / kUnit);
    for (std::size_t c = 0; c < 3; ++c) {
      const float wanted = std::min(view.background[c], greatest);
      CHECK_NEAR(linear[c], wanted, 1e-6 + 1e-6 * double{wanted});
    }
  }
  // Particles on a bright background add their light until the sum reaches its maximum.
  view = small_view(70, 70);
  view.background = {4000, 4000, 4000};
  const auto linear = linear_picture(view, message(Cloud(9000), {Sprite::Kind::disc, 3}, view));
  CHECK(*std::min_element(linear.begin(), linear.end()) >= 3999.9f);
  CHECK(*std::max_element(linear.begin(), linear.end()) == static_cast<float>(4294967295.0 / kUnit));
}

TEST(image_light_of_a_disc_does_not_depend_on_its_position) {
  View view = small_view(64, 64);
  view.background = {0, 0, 0};
  for (int pixels = 1; pixels <= 15; ++pixels) {
    double first = 0;
    for (int step = 0; step < 40; ++step) {
      Cloud one(1);
      one.place(0, 0.017f * static_cast<float>(step), 0.0093f * static_cast<float>(step), 0);
      const auto linear = linear_picture(view, message(one, {Sprite::Kind::disc, pixels}, view));
      const double sum = std::accumulate(linear.begin(), linear.end(), 0.0);
      if (step == 0) first = sum;
      CHECK(sum > 0.9);
      CHECK_NEAR(sum / first, 1, 1e-6);
    }
  }
}

TEST(image_the_centre_of_light_follows_the_particle) {
  View view = small_view(64, 64);
  view.background = {0, 0, 0};
  const double focal = 32 / std::tan(20 * 3.14159265358979323846 / 180);
  for (const int pixels : {1, 2, 3, 4, 5, 9, 12}) {
    for (int step = 0; step < 40; ++step) {
      const float x = 0.0171f * static_cast<float>(step);
      Cloud one(1);
      one.place(0, x, 0, 0);
      const auto linear = linear_picture(view, message(one, {Sprite::Kind::disc, pixels}, view));
      double sum = 0, moment = 0;
      for (std::size_t i = 0; i < linear.size(); i += 3) {
        sum += linear[i];
        moment += linear[i] * (static_cast<double>(i / 3 % 64) + 0.5);
      }
      CHECK_NEAR(moment / sum, 32 + focal * x / 10, pixels == 2 || pixels == 3 ? 0.3 : 0.15);
    }
  }
}

TEST(image_solids_hide_what_is_behind_them) {
  View view = small_view();
  view.objects = {sphere_at_origin(1)};
  const auto bare = picture(view, {});
  Cloud behind(1), before(1), beside(1), resting(1);
  behind.place(0, 0.1f, 0.1f, -2);
  before.place(0, 0.1f, 0.1f, 2);
  beside.place(0, 2, 0, -2);
  resting.place(0, 0, 0, 1);
  CHECK(picture(view, {message(behind, {}, view)}) == bare);
  CHECK(picture(view, {message(before, {}, view)}) != bare);
  CHECK(picture(view, {message(beside, {}, view)}) != bare);
  CHECK(picture(view, {message(resting, {}, view)}) != bare);
  // Per pixel: a particle that is half hidden loses only part of its light.
  const auto light = [&](float x) {
    Cloud edge(1);
    edge.place(0, x, 0, -3);
    const auto linear = linear_picture(view, message(edge, {Sprite::Kind::disc, 15}, view));
    Canvas canvas;
    canvas.begin(view, true);
    canvas.finish();
    const auto alone = canvas.linear();
    return std::accumulate(linear.begin(), linear.end(), 0.0) - std::accumulate(alone.begin(), alone.end(), 0.0);
  };
  const double seen = light(2.5f), half = light(1.31f);
  CHECK(half > 0.2 * seen && half < 0.8 * seen);
}

TEST(image_sizes_that_fit_no_tile) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, {1, 300}, {300, 1}, {64, 64}, {65, 63}, {4096, 8}, {9000, 3}, {16384, 2}}) {
    View view = small_view(width, height);
    view.camera.fov_deg = 20;
    const auto records = message(random_cloud(3000, 9), {Sprite::Kind::disc, 15}, view);
    const auto pixels = picture(view, {records});
    CHECK(pixels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    const Cloud center(1);
    const auto lit = picture(view, {message(center, {Sprite::Kind::disc, 5}, view)});
    const std::size_t middle = 3 * (static_cast<std::size_t>(height / 2) * static_cast<std::size_t>(width) +
                                    static_cast<std::size_t>(width / 2));
    CHECK(lit[middle] > 100);
  }
}

TEST(image_particles_on_the_edge_light_what_is_inside) {
  View view = small_view(64, 64);
  view.background = {0, 0, 0};
  const double reach = std::tan(20 * 3.14159265358979323846 / 180) * 10;
  Cloud corner(1);
  corner.place(0, static_cast<float>(reach), static_cast<float>(reach), 0);
  const auto linear = linear_picture(view, message(corner, {Sprite::Kind::disc, 8}, view));
  const auto whole = linear_picture(view, message(Cloud(1), {Sprite::Kind::disc, 8}, view));
  const double part = std::accumulate(linear.begin(), linear.end(), 0.0);
  CHECK_NEAR(part / std::accumulate(whole.begin(), whole.end(), 0.0), 0.25, 0.03);
  CHECK(linear[63 * 3] > 0 && linear[0] == 0);
}

TEST(image_tone_with_16_bits_is_within_a_step_of_the_curve) {
  std::vector<float> light;
  for (double x = 1e-9; x < 1e5; x *= 1.00137) light.push_back(static_cast<float>(x));
  for (const double exposure : {0.25, 1.0, 7.0}) {
    const std::vector<std::uint16_t> shown = tone_16_bits(light, exposure);
    for (std::size_t i = 0; i < light.size(); ++i) {
      CHECK_NEAR(shown[i], srgb(roll_off(light[i] * exposure)) * 65535, 1.0);
      CHECK(i == 0 || shown[i] >= shown[i - 1]);
    }
  }
  const float infinite = std::numeric_limits<float>::infinity();
  const std::vector<float> odd = {0, -1, -infinite, std::numeric_limits<float>::quiet_NaN(), infinite};
  const std::vector<std::uint16_t> shown = tone_16_bits(odd, 1);
  CHECK(shown == std::vector<std::uint16_t>({0, 0, 0, 0, 65535}));
}

TEST(image_tone_is_smooth_and_within_half_a_step) {
  const auto table = tone_table(1);
  const auto shown = [&](std::uint32_t sum) {
    std::uint8_t byte = 0;
    splat_lanes().tone(&sum, 1, 0, 0, table.data(), &byte);
    return byte;
  };
  int before = 0;
  for (double light = 1e-5; light < 4000; light *= 1.01) {
    const int byte = shown(static_cast<std::uint32_t>(light * kUnit));
    CHECK(byte >= before && byte - before <= 2);
    CHECK_NEAR(byte, srgb(roll_off(light)) * 255, 1.0);
    before = byte;
  }
  CHECK(shown(0) == 0 && shown(0xffffffffu) >= 254);
}

TEST(image_dither_keeps_the_mean_of_a_flat_light_and_whole_bytes) {
  const auto table = tone_table(1);
  constexpr int kSide = 64;
  const auto mean_of = [&](std::uint32_t sum, bool& flat) {
    const std::vector<std::uint32_t> sums(3 * kSide, sum);
    std::vector<std::uint8_t> shown(3 * kSide);
    double all = 0;
    flat = true;
    for (int y = 0; y < kSide; ++y) {
      splat_lanes().tone(sums.data(), sums.size(), 128, y, table.data(), shown.data());
      for (const std::uint8_t byte : shown) all += byte, flat &= byte == shown[0];
    }
    return all / (3 * kSide * kSide);
  };
  bool flat = false;
  for (double light = 1e-4; light < 0.5; light *= 1.037) {
    CHECK_NEAR(mean_of(static_cast<std::uint32_t>(light * kUnit), flat), srgb(light) * 255, 0.08);
  }
  for (int byte = 0; byte < 180; ++byte) {
    const double value = byte / 255.0, light = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    CHECK_NEAR(mean_of(static_cast<std::uint32_t>(light * kUnit + 0.5), flat), byte, 1e-9);
    CHECK(flat);
  }
}

TEST(image_tone_of_many_sums_is_that_of_each) {
  const auto table = tone_table(1);
  std::mt19937 draw(3);
  std::vector<std::uint32_t> sums(400);
  for (std::uint32_t& sum : sums) sum = static_cast<std::uint32_t>(draw()) >> draw() % 32;
  for (const auto* lanes : usable_splat_lanes()) {
    for (std::size_t count = 0; count < sums.size(); ++count) {
      std::vector<std::uint8_t> shown(count + 1, 7);
      lanes->tone(sums.data(), count, 5, 9, table.data(), shown.data());
      bool same = shown[count] == 7;
      for (std::size_t i = 0; i < count; ++i) {
        std::uint8_t alone = 0;
        splat_lanes().tone(&sums[i], 1, 5 + static_cast<int>(i / 3), 9, table.data(), &alone);
        same &= shown[i] == alone;
      }
      CHECK(same);
    }
  }
}

TEST(image_background_and_exposure) {
  View view = small_view(10, 10);
  view.background = {0.25f, 0.04f, 0};
  const auto pixels = picture(view, {});
  CHECK_NEAR(pixels[0], srgb(0.25) * 255, 0.8);
  CHECK_NEAR(pixels[1], srgb(0.04) * 255, 0.8);
  CHECK(pixels[2] == 0);
  view.exposure = 0.5f;
  CHECK_NEAR(picture(view, {})[0], srgb(0.125) * 255, 0.8);
  view.exposure = 0;  // where a film has faded out
  image::check(view);
  const auto faded = picture(view, {});
  CHECK(std::ranges::all_of(faded, [](std::uint8_t shown) { return shown == 0; }));
  view.exposure = 0.5f;
  Canvas canvas;
  CHECK_THROWS(canvas.finish(), std::logic_error);
  canvas.begin(view);
  CHECK(canvas.finish() == picture(view, {}));
  CHECK_THROWS(canvas.linear(), std::logic_error);
  view.exposure = 1;
  canvas.begin(view);  // a changed exposure must not show the old scenery
  CHECK(canvas.finish() == pixels);
}

}  // namespace motes::test_image_canvas
