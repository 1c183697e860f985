// Opaque, alpha and additive sprites of fixed size in one tile, compared with references that evaluate every fragment.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "image/balls/ball_lanes.h"
#include "image/camera.h"
#include "image/light/daylight.h"
#include "image/test_image_painter_scene.h"
#include "support/check.h"

namespace motes::test_image_blends {
using namespace image_test;
using Blend = Sprite::Blend;
using Kind = Sprite::Kind;

namespace {

Sprite sprite_of(Kind kind, Blend blend, int pixels, float softness = 0) {
  Sprite s{kind};
  s.blend = blend;
  s.pixels = pixels;
  s.softness = softness;
  return s;
}

// Calls `use` for each of the tile's pixels that the record's footprint touches.
template <class Use>
void for_each_fragment(const Splat& s, const DeepRecord& r, const Area& area, const Use& use) {
  const int x = r.x - s.origin_x, y = r.y - s.origin_y;
  const int column = static_cast<int>(std::floor(x / 16.0)), row = static_cast<int>(std::floor(y / 16.0));
  const int phase_x = (x & 15) >> (4 - s.phase_bits), phase_y = (y & 15) >> (4 - s.phase_bits);
  for (int dy = 0; dy < s.size; ++dy) {
    for (int dx = 0; dx < s.size; ++dx) {
      if (column + dx < 0 || column + dx >= area.width || row + dy < 0 || row + dy >= area.height) continue;
      const int phase = phase_y << s.phase_bits | phase_x;
      const unsigned char* ball = nullptr;
      if (s.balls != nullptr) {
        ball = MOTES_ISA::ball_at(*s.balls, MOTES_ISA::ball_units(*s.balls->look, column, row, phase));
        ball += dy * s.balls->look->row_bytes;
      }
      use(static_cast<std::size_t>((row + dy) * area.width + column + dx),
          static_cast<std::size_t>(phase * s.size + dy), static_cast<std::size_t>(dx), ball);
    }
  }
}

struct Seen {
  float depth = std::numeric_limits<float>::infinity();
  std::uint32_t surface = 0xffffffffu;
};

// Returns the nearest opaque fragment of each pixel.
std::vector<Seen> nearest_of(const std::vector<Batch>& batches, const Area& area) {
  std::vector<Seen> nearest(static_cast<std::size_t>(area.width * area.height));
  for (const Batch& batch : batches) {
    if (!batch.brush.blends(Blend::opaque)) continue;
    const Splat s = batch.brush.splat_at(area.x, area.y);
    for (std::size_t i = 0; i < batch.count(); ++i) {
      const auto r = batch.record<DeepRecord>(i);
      for_each_fragment(s, r, area,
                        [&](std::size_t pixel, std::size_t row, std::size_t column, const unsigned char* ball) {
                          if ((s.covered[row] >> column & 1) == 0) return;
                          const std::uint32_t shade = ball == nullptr ? 255 : ball[column];
                          const float center = depth_of(r);
                          Seen here{center, shade << 24 | static_cast<std::uint32_t>(r.color[2]) << 16 |
                                                static_cast<std::uint32_t>(r.color[1]) << 8 | r.color[0]};
                          if (s.bulge != nullptr)
                            here.depth = center - center * s.radius * s.bulge[row * surface_row(s.size) + column];
                          Seen& old = nearest[pixel];
                          if (std::tie(here.depth, here.surface) < std::tie(old.depth, old.surface)) old = here;
                        });
    }
  }
  return nearest;
}

// Blends all fragments of alpha and additive records, sorted, in double precision on top of `light`. `deep`: the same
// batches with the depths that are compared with the wall's.
std::vector<double> blended(std::vector<double> light, const std::vector<Batch>& batches,
                            const std::vector<Batch>& deep, const Area& area, const std::vector<float>& wall) {
  struct Item {
    float depth;
    const Batch* batch;
    std::size_t record;
  };
  std::vector<Item> items;
  for (const Batch& batch : batches) {
    if (batch.brush.blends(Blend::opaque)) continue;
    for (std::size_t i = 0; i < batch.count(); ++i) {
      items.push_back({depth_of(batch.record<DeepRecord>(i)), &batch, i});
    }
  }
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
    if (a.depth != b.depth) return a.depth > b.depth;
    if (a.batch != b.batch) return a.batch->brush < b.batch->brush;
    const std::size_t size = a.batch->brush.record_bytes();
    return std::memcmp(a.batch->bytes.data() + a.record * size, b.batch->bytes.data() + b.record * size, size) < 0;
  });
  for (const Item& item : items) {
    const Splat s = item.batch->brush.splat_at(area.x, area.y);
    const auto r = item.batch->record<DeepRecord>(item.record);
    const float depth =
        depth_of(deep[static_cast<std::size_t>(item.batch - batches.data())].record<DeepRecord>(item.record));
    const bool alpha = item.batch->brush.blends(Blend::alpha);
    for_each_fragment(
        s, r, area, [&](std::size_t pixel, std::size_t row, std::size_t column, const unsigned char* ball) {
          if (wall[pixel] < depth) return;
          const double fade = s.fade > 0 ? std::min(1.0, (static_cast<double>(wall[pixel]) - depth) * s.fade) : 1;
          const std::size_t at = row * static_cast<std::size_t>(s.row_bytes) + 3 * column;
          const double a = r.alpha / 255.0 * fade;
          for (std::size_t c = 0; c < 3; ++c) {
            double& l = light[3 * pixel + c];
            const int weight = ball == nullptr ? s.weights[at] : ball[3 * column];
            if (alpha) l *= 1 - a * s.weights[at] / 255.0;
            l += r.color[c] / 255.0 * a * weight / 255.0;
          }
        });
  }
  return light;
}

std::vector<Piece> whole(const std::vector<Batch>& batches) {
  std::vector<Piece> pieces;
  for (const Batch& b : batches) pieces.push_back(b.piece());
  return pieces;
}

// Returns batches of every blend and kind of fixed size.
std::vector<Batch> mixed(const View& view, std::uint64_t seed) {
  std::vector<Batch> batches;
  batches.push_back(random_batch(sprite_of(Kind::disc, Blend::opaque, 5), view, 60, seed));
  batches.push_back(random_batch(sprite_of(Kind::sphere, Blend::opaque, 9), view, 40, seed + 1));
  batches.push_back(random_batch(sprite_of(Kind::point, Blend::opaque, 1), view, 200, seed + 2));
  batches.push_back(random_batch(sprite_of(Kind::disc, Blend::alpha, 7), view, 500, seed + 3));
  batches.push_back(random_batch(sprite_of(Kind::sphere, Blend::alpha, 4, 2.0f), view, 300, seed + 4));
  batches.push_back(random_batch(sprite_of(Kind::disc, Blend::add, 5), view, 500, seed + 5));
  batches.push_back(random_batch(sprite_of(Kind::sphere, Blend::add, 15), view, 50, seed + 6));
  batches.push_back(random_batch(sprite_of(Kind::disc, Blend::add, 3, 0.7f), view, 500, seed + 7));
  return batches;
}

}  // namespace

TEST(image_of_opaque_particles_the_nearest_shows) {
  for (const bool solid : {false, true}) {
    const View view = painter_view(solid);
    for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere}) {
      for (const int pixels : {1, 2, 5, 8, 15}) {
        const std::vector<Batch> batches{random_batch(sprite_of(kind, Blend::opaque, pixels), view, 150, 9)};
        for (int tile = 0; tile < 4; ++tile) {
          PaintedTile painted(view, tile);
          const auto bare = painted.paint({});
          const auto wall = painted.hides();
          painted.painter.start(painted.area);
          const auto light = painted.paint(whole(batches));
          const auto depth = painted.hides();
          const auto nearest = nearest_of(settled(batches, painted), painted.area);
          for (std::size_t i = 0; i < nearest.size(); ++i) {
            const bool hidden = !(nearest[i].depth <= wall[i]) || std::isinf(nearest[i].depth);
            CHECK(depth[i] == (hidden ? wall[i] : nearest[i].depth));
            for (std::size_t c = 0; c < 3; ++c) {
              const double shade = (nearest[i].surface >> 24) / 255.0;
              const double expected = (nearest[i].surface >> (8 * c) & 0xffu) / 255.0 * shade;
              if (hidden) {
                CHECK(light[3 * i + c] == bare[3 * i + c]);
              } else {
                CHECK_NEAR(light[3 * i + c], expected, 0.001);
              }
            }
          }
        }
      }
    }
  }
}

TEST(image_a_particle_on_a_solid_is_seen_whatever_its_color) {
  const View view = painter_view(true);
  PaintedTile painted(view);
  const auto bare = painted.paint({});
  const std::vector<float> wall = painted.hides(), surface = painted.depth();
  const int width = painted.area.width;
  const auto middle = static_cast<std::size_t>(width * painted.area.height / 2 + width / 2);
  std::size_t on = middle;  // a pixel of the solid
  while (on < wall.size() && !(wall[on] < 100)) ++on;
  CHECK(on < wall.size());
  for (const std::uint8_t blue : {std::uint8_t{254}, std::uint8_t{255}}) {
    Batch one(sprite_of(Kind::point, Blend::opaque, 1), Layout::deep, view);
    DeepRecord r{};
    r.x = static_cast<std::int16_t>(16 * (static_cast<int>(on) % width - view.width / 2) + 8);
    r.y = static_cast<std::int16_t>(16 * (static_cast<int>(on) / width - view.height / 2) + 8);
    r.color[0] = r.color[1] = 255;
    r.color[2] = blue;
    r.alpha = 255;
    std::memcpy(&r.depth, &surface[on], 4);
    one.put(r);
    painted.painter.start(painted.area);
    const auto light = painted.paint({one.piece()});
    CHECK_NEAR(light[3 * on], 1, 0.001);
    CHECK(light[3 * on] > bare[3 * on] + 0.1);
    PaintedTile part(view);  // another rank's
    const auto bytes = part.partial({one.piece()});
    painted.painter.start(painted.area);
    painted.painter.merge(bytes);
    CHECK(painted.paint({}) == light);
  }
}

TEST(image_every_opaque_particle_covers_some_pixel) {
  View view = painter_view();
  view.background = {0, 0, 0};
  for (const Kind kind : {Kind::point, Kind::disc, Kind::sphere}) {
    for (const int pixels : {1, 2, 3, 5, 10}) {
      for (std::int16_t step = 0; step < 16; ++step) {
        Batch one(sprite_of(kind, Blend::opaque, pixels), Layout::deep, view);
        one.put(DeepRecord{static_cast<std::int16_t>(step - 200),
                           static_cast<std::int16_t>(2 * step - 200),
                           {255, 255, 255},
                           1,
                           0x41000000});
        PaintedTile painted(view);
        painted.paint({one.piece()});
        const auto depth = painted.depth();
        const auto covered = std::count_if(depth.begin(), depth.end(), [](float d) { return d < 100; });
        const double area = kind == Kind::point || pixels == 1 ? 1 : 0.25 * 3.14159265 * pixels * pixels;
        CHECK(covered >= 1);
        CHECK_NEAR(static_cast<double>(covered), area, 0.9 + 0.25 * area);
      }
    }
  }
}

TEST(image_alpha_and_light_agree_with_sorting_every_fragment) {
  for (const bool solid : {false, true}) {
    const View view = painter_view(solid);
    for (std::uint64_t seed = 1; seed < 4; ++seed) {
      const std::vector<Batch> batches = mixed(view, 100 * seed);
      for (int tile = 0; tile < 4; ++tile) {
        PaintedTile painted(view, tile);
        std::vector<Piece> opaque, all = whole(batches);
        std::copy_if(all.begin(), all.end(), std::back_inserter(opaque),
                     [](const Piece& p) { return p.brush->blends(Blend::opaque); });
        const auto surfaces = painted.paint(opaque);
        const auto wall = painted.hides();
        const auto expected =
            blended({surfaces.begin(), surfaces.end()}, batches, settled(batches, painted), painted.area, wall);
        painted.painter.start(painted.area);
        const auto light = painted.paint(all);
        CHECK(painted.hides() == wall);
        double worst = 0;
        for (std::size_t i = 0; i < light.size(); ++i) worst = std::max(worst, std::fabs(light[i] - expected[i]));
        CHECK_NEAR(worst, 0, 1 / 255.0);
      }
    }
  }
}

TEST(image_many_layers_of_alpha_stay_exact) {
  // 3000 layers over one pixel: errors must not pile up.
  const View view = painter_view();
  std::vector<Batch> batches{Batch(sprite_of(Kind::disc, Blend::alpha, 9), Layout::deep, view)};
  test::Dice dice(5);
  for (int i = 0; i < 3000; ++i) {
    DeepRecord r{-300, -300, {0, 0, 0}, static_cast<std::uint8_t>(dice.below(30)), 0};
    for (auto& c : r.color) c = static_cast<std::uint8_t>(dice.below(256));
    const float depth = dice.between(5, 15);
    std::memcpy(&r.depth, &depth, 4);
    batches[0].put(r);
  }
  PaintedTile painted(view);
  const auto bare = painted.paint({});
  const auto expected = blended({bare.begin(), bare.end()}, batches, batches, painted.area, painted.hides());
  painted.painter.start(painted.area);
  const auto light = painted.paint(whole(batches));
  for (std::size_t i = 0; i < light.size(); ++i) CHECK_NEAR(light[i], expected[i], 1 / 255.0);
}

TEST(image_blends_do_not_depend_on_order_pieces_or_isa) {
  for (const bool solid : {false, true}) {
    const View view = painter_view(solid);
    std::vector<Batch> batches = mixed(view, 7);
    PaintedTile painted(view, 1);
    const auto reference = painted.paint(whole(batches));
    const auto depths = painted.depth();
    test::Dice dice(8);
    for (int round = 0; round < 5; ++round) {
      const std::vector<Piece> pieces = shuffled_pieces(batches, dice);
      for (const SplatLanes* lanes : usable_splat_lanes()) {
        PaintedTile other(view, 1, *lanes);
        CHECK(other.paint(pieces) == reference);
        CHECK(other.depth() == depths);
      }
    }
  }
}

TEST(image_additive_light_is_the_same_sorted_and_unsorted) {
  const View view = painter_view(true);
  const Batch added = random_batch(sprite_of(Kind::disc, Blend::add, 5), view, 20000, 3);
  Batch invisible(sprite_of(Kind::disc, Blend::alpha, 5), Layout::deep, view);
  invisible.put(DeepRecord{0, 0, {9, 9, 9}, 0, 0x41200000});
  PaintedTile painted(view);
  const auto unsorted = painted.paint({added.piece()});
  painted.painter.start(painted.area);
  CHECK(painted.paint({added.piece(), invisible.piece()}) == unsorted);
}

TEST(image_crowds_stay_at_the_greatest_sum_when_sorted) {
  const View view = painter_view();
  Batch added(sprite_of(Kind::disc, Blend::add, 3), Layout::deep, view);
  for (int i = 0; i < 6000; ++i) added.put(DeepRecord{-400, -300, {255, 255, 255}, 255, 0x41200000});
  Batch veil(sprite_of(Kind::disc, Blend::alpha, 3), Layout::deep, view);
  veil.put(DeepRecord{-400, -300, {0, 0, 0}, 1, 0x41300000});  // behind all others
  PaintedTile painted(view);
  const auto plain = painted.paint({added.piece()});
  painted.painter.start(painted.area);
  const auto sorted = painted.paint({veil.piece(), added.piece()});
  CHECK(*std::max_element(sorted.begin(), sorted.end()) == *std::max_element(plain.begin(), plain.end()));
  CHECK(sorted[0] > 0);
}

TEST(image_opaque_particles_may_come_in_partial_tiles) {
  for (const bool solid : {false, true}) {
    const View view = painter_view(solid);
    std::vector<Batch> batches = mixed(view, 21);
    PaintedTile painted(view, 1);
    const auto reference = painted.paint(whole(batches));
    PaintedTile first(view, 1), second(view, 1), owner(view, 1);
    std::vector<Piece> rest;
    for (const Batch& b : batches) {
      if (!b.brush.blends(Blend::opaque)) rest.push_back(b.piece());
    }
    const auto one = first.partial({batches[0].piece(), batches[1].piece(0, 11)});
    const auto two = second.partial({batches[1].piece(11), batches[2].piece()});
    for (const bool swapped : {false, true}) {
      owner.painter.start(owner.area);
      owner.painter.merge(swapped ? two : one);
      owner.painter.merge(swapped ? one : two);
      CHECK(owner.paint(rest) == reference);
    }
    CHECK_THROWS(first.partial(rest), std::logic_error);
    CHECK_THROWS(first.partial({batches[0].piece(), batches[5].piece()}), std::logic_error);
  }
}

TEST(image_a_sphere_is_as_round_as_ray_tracing_says) {
  View view = painter_view();
  view.camera.fov_deg = 3;  // parallel enough: a sphere's outline is a circle
  const double focal = lens(view).focal_px;
  for (const int pixels : {5, 10, 15}) {
    for (std::int16_t step = -16; step < 0; step += 3) {
      const float distance = 10;
      Batch one(sprite_of(Kind::sphere, Blend::opaque, pixels), Layout::deep, view);
      DeepRecord r{
          static_cast<std::int16_t>(step - 240), static_cast<std::int16_t>(step - 200), {255, 255, 255}, 255, 0};
      std::memcpy(&r.depth, &distance, 4);
      one.put(r);
      PaintedTile painted(view);
      painted.paint({one.piece()});
      const auto depth = painted.depth();
      // In metres, with z to the camera's front.
      const double radius = 0.5 * pixels / focal * distance;
      const double cx = (r.x + 0.5) / 16 / focal * distance, cy = (r.y + 0.5) / 16 / focal * distance;
      double worst = 0;
      for (int y = 0; y < painted.area.height; ++y) {
        for (int x = 0; x < painted.area.width; ++x) {
          const double dx = (x + 0.5 - 60) / focal, dy = (y + 0.5 - 45) / focal;
          // |t d - c|^2 = radius^2 with d = (dx, dy, 1), c = (cx, cy, distance)
          const double dd = dx * dx + dy * dy + 1, dc = dx * cx + dy * cy + distance;
          const double rest = cx * cx + cy * cy + distance * distance - radius * radius;
          const double under = dc * dc - dd * rest;
          const float seen = depth[static_cast<std::size_t>(y * painted.area.width + x)];
          if (under < 0.25 * radius * radius * dd) continue;  // near the rim a quarter of a pixel makes a difference
          CHECK(seen < 100);
          worst = std::max(worst, std::fabs(seen - (dc - std::sqrt(under)) / dd) / radius);
        }
      }
      CHECK(worst < 0.13);  // of the radius; positions are rounded to a quarter or an eighth of a pixel
    }
  }
}

TEST(image_spheres_are_brighter_toward_the_sun) {
  const View view = painter_view();
  Batch one(sprite_of(Kind::sphere, Blend::opaque, 15), Layout::deep, view);
  one.put(DeepRecord{-480, -240, {255, 255, 255}, 255, 0x41200000});
  PaintedTile painted(view);
  const auto light = painted.paint({one.piece()});
  const auto at = [&](int x, int y) { return light[static_cast<std::size_t>(3 * (y * painted.area.width + x))]; };
  CHECK(at(27, 25) > 0.8 && at(33, 35) < 0.25);  // the sun stands to the left, above, behind the camera
}

TEST(image_soft_particles_fade_where_they_touch_a_solid) {
  View view = painter_view(true);
  view.background = {0, 0, 0};
  const auto light = [&](Blend blend, float softness, float depth) {
    Batch one(sprite_of(Kind::disc, blend, 9, softness), Layout::deep, view);
    DeepRecord r{-16, -16, {255, 255, 255}, 255, 0};
    std::memcpy(&r.depth, &depth, 4);
    one.put(r);
    PaintedTile painted(view);
    const auto bare = painted.paint({});
    painted.painter.start(painted.area);
    const auto lit = painted.paint({one.piece()});
    double sum = 0;
    for (std::size_t i = 0; i < lit.size(); ++i) sum += std::fabs(lit[i] - bare[i]);
    return sum;
  };
  for (const Blend blend : {Blend::add, Blend::alpha}) {
    const double whole = light(blend, 0, 7.5f);  // the ball's front is at a depth of 8
    CHECK(whole > 10 && light(blend, 0, 7.99f) == whole && light(blend, 0, 9) == 0);
    CHECK_NEAR(light(blend, 1, 7.5f) / whole, 0.5, 0.03);
    CHECK_NEAR(light(blend, 2, 7.5f) / whole, 0.25, 0.03);
    CHECK(light(blend, 0.25f, 7.5f) == whole);
    CHECK(light(blend, 1, 7.99f) < 0.05 * whole);
  }
}

}  // namespace motes::test_image_blends
