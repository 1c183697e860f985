// Records of a system with one colour omit it, and no picture shows a difference.
#include <algorithm>
#include <stdexcept>
#include <vector>

#include "image/raster/ordered.h"
#include "image/raster/pieces.h"
#include "image/test_image_wide_scene.h"
#include "support/check.h"

namespace motes::test_image_colors {
using namespace image_test;

namespace {

constexpr float kColor[] = {0.9f, 0.5f, 0.25f}, kAlpha = 0.6f;

// Particles of one colour, with the other columns of records; the colour's planes have the same value for each
// particle.
struct OneColor {
  Cloud cloud;
  std::vector<float> size, velocity[3];

  explicit OneColor(std::size_t count, std::uint64_t seed) : cloud(random_cloud(count, seed)) {
    test::Dice dice(seed);
    size.assign(count + 16, 0);
    for (float& s : size) s = dice.between(0.02f, 0.5f);
    for (auto& v : velocity) {
      v.assign(count + 16, 0);
      for (float& axis : v) axis = dice.between(-20, 20);
    }
    for (std::size_t c = 0; c < 3; ++c) std::fill(cloud.color[c].begin(), cloud.color[c].end(), kColor[c]);
    std::fill(cloud.alpha.begin(), cloud.alpha.end(), kAlpha);
  }
  Drawn drawn(bool planes) const {
    Drawn d = cloud.drawn();
    d.size = size.data();
    for (std::size_t c = 0; c < 3; ++c) {
      d.velocity[c] = velocity[c].data();
      d.color_of_all[c] = kColor[c];
      if (!planes) d.color[c] = nullptr;
    }
    d.alpha_of_all = kAlpha;
    if (!planes) d.alpha = nullptr;
    return d;
  }
};

struct Seen {
  std::vector<float> light, depth, velocity;
  bool operator==(const Seen&) const = default;
};

Seen tile_of(const std::vector<std::vector<std::byte>>& messages, const View& view, int tile, const SplatLanes& lanes,
             const WideLanes& wide) {
  Pieces all;
  all.begin(view);
  for (const auto& message : messages) all.add(message);
  std::vector<Piece> pieces;
  all.collect(tile, pieces);
  PaintedTile painted(view, tile, lanes, wide);
  Seen seen{painted.paint(pieces), painted.depth(), {}};
  const auto row = static_cast<std::size_t>(3 * painted.area.width);
  seen.velocity.resize(row * static_cast<std::size_t>(painted.area.height));
  if ((view.layers & kVelocityLayer) != 0) painted.painter.velocity(pieces, seen.velocity.data(), row);
  return seen;
}

// Returns whether messages with and without colours look the same in each build of the kernels.
bool look_alike(const std::vector<std::vector<std::byte>>& with, const std::vector<std::vector<std::byte>>& without,
                const View& view) {
  const auto lanes = usable_splat_lanes();
  const auto wides = usable_wide_lanes();
  bool alike = true;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    for (int tile = 0; tile < 4; ++tile) {
      alike &= tile_of(with, view, tile, *lanes[i], *wides[i]) == tile_of(without, view, tile, *lanes[i], *wides[i]);
    }
  }
  return alike;
}

}  // namespace

TEST(image_records_without_colors_look_the_same) {
  const OneColor one(1501, 3);
  for (const Blend blend : {Blend::add, Blend::opaque}) {
    for (const auto& [kind, pixels] : {std::pair{Kind::point, 1},
                                       {Kind::disc, 2},
                                       {Kind::disc, 5},
                                       {Kind::disc, 12},
                                       {Kind::disc, 0},
                                       {Kind::sphere, 6},
                                       {Kind::sphere, 0}}) {
      for (int variant = 0; variant < 8; ++variant) {
        View view = painter_view((variant & 1) != 0);
        if ((variant & 2) != 0) view.shutter = 0.5f;
        if (blend == Blend::opaque) view.layers = kVelocityLayer;
        Sprite sprite{kind, pixels};
        sprite.blend = blend;
        if ((variant & 4) != 0) sprite.softness = 0.7f;
        Projection projection;
        projection.dt = 0.05;
        const auto with = projected(one.drawn(true), sprite, view, projection);
        const auto without = projected(one.drawn(false), sprite, view, projection);
        const RecordsView colored(with), colorless(without);
        CHECK(colored.colored() && !colorless.colored() && colored.count() > 500);
        CHECK(colorless.count() == colored.count() && colorless.record_bytes() + 4 == colored.record_bytes());
        CHECK(look_alike({with}, {without}, view));
      }
    }
  }
}

// Each message has its own colour, though the painter draws them with one brush.
TEST(image_messages_of_several_colors_keep_them) {
  const View view = painter_view(true);
  const OneColor first(400, 5), second(400, 6);
  for (const Sprite& sprite : {Sprite{Kind::disc, 5}, Sprite{Kind::disc, 0}, Sprite{Kind::point, 1}}) {
    std::vector<std::vector<std::byte>> messages[2];
    for (const bool planes : {true, false}) {
      Drawn other = second.drawn(planes);
      other.color_of_all[0] = 0.1f;
      std::vector<float> red(416, 0.1f);
      if (planes) other.color[0] = red.data();
      for (const Drawn& drawn : {first.drawn(planes), other, first.drawn(true)}) {
        messages[planes].push_back(projected(drawn, sprite, view, {}));
      }
    }
    CHECK(look_alike(messages[1], messages[0], view));
    Seen seen[2];
    for (const std::size_t i : {0u, 1u}) seen[i] = tile_of({messages[0][i]}, view, 0, splat_lanes(), wide_lanes());
    CHECK(!(seen[0] == seen[1]));
  }
}

TEST(image_records_that_are_put_in_order_keep_their_colors) {
  const View view = painter_view();
  const OneColor one(50, 7);
  const Drawn drawn = one.drawn(false);
  const Sprite spark{Kind::disc, 5};
  Sprite smoke = spark, leaf{Kind::image, 0};
  smoke.blend = Blend::alpha;
  leaf.sheet()->picture = two_colors();
  CHECK(!RecordsView(projected(drawn, spark, view, {})).colored());
  CHECK(RecordsView(projected(drawn, smoke, view, {})).colored());
  CHECK(RecordsView(projected(drawn, leaf, view, {})).colored());
  CHECK(in_order_of_depth(std::vector<Sprite>{spark, smoke}) && !in_order_of_depth(std::vector<Sprite>{spark, leaf}));
  Projection beside_smoke;
  beside_smoke.in_order = true;
  beside_smoke.any_depth = true;
  CHECK(RecordsView(projected(drawn, spark, view, beside_smoke)).colored());
  const Brush colorless(spark, Layout::deep, view, false);
  const std::vector<std::byte> record(colorless.record_bytes());
  const std::vector<Piece> pieces{{&colorless, record.data(), 1}};
  CHECK_THROWS(Ordered().sort(pieces), std::runtime_error);
}

}  // namespace motes::test_image_colors
