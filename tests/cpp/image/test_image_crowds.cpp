// Opaque records behind others that are already drawn are skipped, and no picture shows a difference.
#include <algorithm>
#include <bit>
#include <limits>
#include <vector>

#include "image/raster/depth_blocks.h"
#include "image/test_image_wide_scene.h"
#include "support/check.h"

namespace motes::test_image_crowds {
using namespace image_test;

namespace {

struct Fixed {
  Kind kind;
  int pixels;
};
constexpr Fixed kFixed[] = {{Kind::point, 1}, {Kind::disc, 5}, {Kind::disc, 12}, {Kind::sphere, 6}, {Kind::sphere, 15}};

Sprite opaque(const Fixed& fixed) {
  Sprite sprite{fixed.kind, fixed.pixels};
  sprite.blend = Blend::opaque;
  return sprite;
}

// Returns records of any size, many of them along streaks, turned.
Batch wide_crowd(const Sprite& sprite, const View& view, std::size_t count) {
  Batch batch(sprite, Layout::wide, view);
  test::Dice dice(41);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = dice.between(-70, 70), y = dice.between(-55, 55);
    WideRecord r = wide_record(x, y, dice.between(2, 20), dice.between(5, 15));
    for (auto& c : r.color) c = static_cast<std::uint8_t>(dice.below(256));
    if (dice.coin()) {
      r.dx = static_cast<std::int32_t>(dice.between(-30, 30) * 256);
      r.dy = static_cast<std::int32_t>(dice.between(-30, 30) * 256);
    }
    if (dice.coin()) {
      r.up_x = 19660;
      r.up_y = 26213;
    }
    batch.put(r);
  }
  return batch;
}

struct Seen {
  std::vector<float> light, depth;
  bool operator==(const Seen&) const = default;
};

// Draws records a few at a time, each time on an empty tile.
Seen one_by_one(const View& view, int tile, const std::vector<Batch>& batches) {
  constexpr std::size_t kFew = 20;
  PaintedTile owner(view, tile), others(view, tile);
  for (const Batch& batch : batches) {
    for (std::size_t i = 0; i < batch.count(); i += kFew) owner.painter.merge(others.partial({batch.piece(i, kFew)}));
  }
  owner.painter.paint({});
  return {owner.light(), owner.depth()};
}

Seen together(const View& view, int tile, const std::vector<Piece>& pieces, const SplatLanes& lanes,
              const WideLanes& wide) {
  PaintedTile painted(view, tile, lanes, wide);
  painted.painter.paint(pieces);
  return {painted.light(), painted.depth()};
}

// Whole tiles, and one that is cut off on two sides.
constexpr int kTiles[] = {0, 3};

void check_crowd(const View& view, Batch batch) {
  for (const int tile : kTiles) {
    const Seen expected = one_by_one(view, tile, {batch});
    CHECK(*std::max_element(expected.light.begin(), expected.light.end()) > 0);
    test::Dice dice(7);
    const auto wides = usable_wide_lanes();
    for (std::size_t build = 0; build < wides.size(); ++build) {
      std::vector<Batch> batches{batch};
      const std::vector<Piece> pieces = shuffled_pieces(batches, dice);
      CHECK(together(view, tile, pieces, *usable_splat_lanes()[build], *wides[build]) == expected);
    }
  }
}

}  // namespace

TEST(image_crowds_of_fixed_size_look_as_if_each_record_was_drawn) {
  for (const bool solids : {false, true}) {
    const View view = painter_view(solids);
    for (const Fixed& fixed : kFixed) check_crowd(view, random_batch(opaque(fixed), view, 9000, 5));
  }
}

TEST(image_crowds_of_any_size_look_as_if_each_record_was_drawn) {
  for (const bool solids : {false, true}) {
    const View view = painter_view(solids);
    for (const Kind kind : {Kind::disc, Kind::sphere, Kind::image}) {
      const meshes::AssetKey picture = kind == Kind::image ? two_colors() : 0;
      check_crowd(view, wide_crowd(wide_sprite(kind, Blend::opaque, picture), view, 4000));
    }
  }
}

// The crowd's own front is known while the rest is drawn, for the footprints of each brush.
TEST(image_crowds_of_several_brushes_look_as_if_each_record_was_drawn) {
  const View view = painter_view();
  test::Dice dice(3);
  for (const int tile : kTiles) {
    std::vector<Batch> batches;
    for (const Fixed& fixed : kFixed) batches.push_back(random_batch(opaque(fixed), view, 3000, batches.size()));
    batches.push_back(wide_crowd(wide_sprite(Kind::sphere, Blend::opaque), view, 1000));
    const Seen expected = one_by_one(view, tile, batches);
    for (int order = 0; order < 3; ++order) {
      const std::vector<Piece> pieces = shuffled_pieces(batches, dice);
      CHECK(together(view, tile, pieces, splat_lanes(), wide_lanes()) == expected);
    }
  }
}

TEST(image_surfaces_are_measured_by_blocks) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  test::Dice dice(11);
  std::vector<NearestSurface> surfaces(kPixelNumbers);
  for (auto& s : surfaces) {
    const float depth = dice.below(50) == 0 ? kInfinity : dice.between(1, 9);
    s = NearestSurface{std::bit_cast<std::uint32_t>(depth)} << 32 | dice.below(0xffffffffu);
  }
  TilePlanes tile{};
  tile.surfaces = surfaces.data() + kFirstPixel;
  for (const Area area : {Area{0, 0, 0, kTile, kTile}, Area{0, 0, 0, 37, 22}, Area{0, 0, 0, 8, 1}}) {
    for (const SplatLanes* lanes : usable_splat_lanes()) {
      DepthBlocks blocks;
      blocks.measure_surfaces(tile, area, *lanes);
      const float* met = blocks.met(tile, area, 1);
      for (int row = 0; row < kTile; row += 8) {
        for (int column = 0; column < kTile; column += 8) {
          float farthest = 0;
          for (int y = row; y < std::min(row + 8, area.height); ++y) {
            for (int x = column; x < std::min(column + 8, area.width); ++x) {
              const auto bits = static_cast<std::uint32_t>(tile.surfaces[y * kPixelStride + x] >> 32);
              farthest = std::max(farthest, std::bit_cast<float>(bits));
            }
          }
          const float* here = met + 2 * DepthBlocks::at(column, row);
          CHECK(here[0] == 0 || farthest == 0);
          CHECK(here[1] == farthest);
        }
      }
    }
  }
}

// Velocities are found by drawing the crowd again, after additive particles of another size.
TEST(image_velocities_of_a_crowd_do_not_depend_on_what_is_added) {
  View view = painter_view();
  view.layers = kVelocityLayer;
  struct Moving {
    DeepRecord record;
    float velocity[3];
  };
  const Sprite ball = opaque({Kind::sphere, 15});
  const Batch still = random_batch(ball, painter_view(), 60, 2);
  Batch balls(ball, Layout::deep, view);
  for (std::size_t i = 0; i < still.count(); ++i) {
    balls.put(Moving{still.record<DeepRecord>(i), {static_cast<float>(i), 1, 2}});
  }
  const Sprite spark{Kind::point, 1};
  const Batch sparks = random_batch(spark, view, 500, 3);
  std::vector<std::vector<float>> found;
  for (const bool with_sparks : {false, true}) {
    std::vector<Piece> pieces{balls.piece()};
    if (with_sparks) pieces.push_back(sparks.piece());
    PaintedTile tile(view);
    tile.painter.paint(pieces);
    found.emplace_back(3 * static_cast<std::size_t>(tile.area.width * tile.area.height));
    tile.painter.velocity(pieces, found.back().data(), 3 * static_cast<std::size_t>(tile.area.width));
  }
  CHECK(*std::max_element(found[0].begin(), found[0].end()) > 10);
  CHECK(found[0] == found[1]);
}

}  // namespace motes::test_image_crowds
