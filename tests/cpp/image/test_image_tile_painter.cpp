#include <cstring>
#include <stdexcept>
#include <utility>

#include "image/raster/tile_painter.h"
#include "image/test_image_painter_scene.h"
#include "support/check.h"

namespace motes::test_image_tile_painter {
using namespace image_test;

namespace {

/// A tile painter with the memory that its users provide.
struct Tile {
  std::vector<std::vector<std::byte>> records;
  PreparedScene scene;
  Pieces messages;
  TilePainter painter;
  Area area;

  Tile(const View& view, int number, std::vector<std::vector<std::byte>> from) : records(std::move(from)) {
    scene.prepare(view);
    scene.render(number);
    messages.begin(view);
    for (const auto& r : records) messages.add(r);
    painter.begin(scene);
    area = scene.grid().area(number);
  }
  void paint() {
    std::vector<Piece> pieces;
    messages.collect(area.tile, pieces);
    painter.paint(pieces);
  }
  std::vector<std::byte> partial() {
    painter.start_bare(area);
    paint();
    Buffer saved;
    painter.save_partial(saved);
    return {saved.data(), saved.data() + saved.size()};
  }
  std::vector<float> light() const { return light_of(painter, area); }
};

}  // namespace

TEST(image_the_areas_of_a_grid_cover_each_pixel_once) {
  for (const Grid grid : {Grid{1, 1}, Grid{64, 64}, Grid{65, 130}, Grid{200, 150}}) {
    std::vector<int> seen(static_cast<std::size_t>(grid.width * grid.height));
    for (int tile = 0; tile < grid.tiles(); ++tile) {
      const Area area = grid.area(tile);
      CHECK(area.tile == tile && area.width > 0 && area.width <= kTile && area.height > 0 && area.height <= kTile);
      for (int y = area.y; y < area.y + area.height; ++y) {
        for (int x = area.x; x < area.x + area.width; ++x) ++seen[static_cast<std::size_t>(y * grid.width + x)];
      }
    }
    for (const int times : seen) CHECK(times == 1);
  }
}

TEST(image_partial_tiles_add_up_to_the_whole_tile) {
  View solid = small_view();
  solid.objects = {ball(0, 0, 2), ball(3, 2, 1)};
  for (const View& view : {small_view(), solid}) {
    for (const std::size_t count : {3u, 40000u}) {
      const Cloud cloud = random_cloud(count, 4);
      const Sprite sprite{Sprite::Kind::disc, 7};
      for (int tile = 0; tile < 12; ++tile) {
        Tile whole(view, tile, {message(cloud, sprite, view)});
        whole.painter.start(whole.area);
        whole.paint();
        // The owner has its own records, and partial tiles from two others, in either order.
        const auto first = Tile(view, tile, {message(every(cloud, 0, 3), sprite, view)}).partial();
        const auto second = Tile(view, tile, {message(every(cloud, 1, 3), sprite, view)}).partial();
        for (const bool swapped : {false, true}) {
          Tile owner(view, tile, {message(every(cloud, 2, 3), sprite, view)});
          owner.painter.start(owner.area);
          owner.painter.merge(swapped ? second : first);
          owner.painter.merge(swapped ? first : second);
          owner.paint();
          CHECK(owner.light() == whole.light());
        }
      }
    }
  }
}

TEST(image_partial_tiles_stay_at_the_greatest_sum) {
  const View view = small_view(70, 70);
  const Cloud crowd(3000);  // all at one place: sums overflow at 4145
  const auto records = message(crowd, {}, view);
  Tile whole(view, 0, {records, records, records});
  whole.painter.start(whole.area);
  whole.paint();
  const auto part = Tile(view, 0, {records}).partial();
  Tile owner(view, 0, {records});
  owner.painter.start(owner.area);
  owner.painter.merge(part);
  owner.painter.merge(part);
  owner.paint();
  CHECK(owner.light() == whole.light());
}

TEST(image_a_partial_tile_holds_only_what_has_light) {
  const View view = small_view(64, 64);
  Cloud one(1);
  const auto some = Tile(view, 0, {message(one, {Sprite::Kind::disc, 5}, view)}).partial();
  CHECK(some.size() > 16 + 4 * 3 * 9 && some.size() <= 16 + 4 * 3 * 25);
  one.place(0, 0, 0, -1000);
  one.alpha[0] = 0;
  one.colored = true;
  CHECK(Tile(view, 0, {message(one, {Sprite::Kind::disc, 5}, view)}).partial().size() == 16);
}

TEST(image_malformed_partial_tiles_are_refused) {
  const View view = small_view(128, 64);
  const auto records = message(random_cloud(500, 5), {}, view);
  const auto good = Tile(view, 0, {records}).partial();
  Tile owner(view, 0, {});
  owner.painter.start(owner.area);
  owner.painter.merge(good);
  for (const std::size_t length : {std::size_t{0}, std::size_t{15}, std::size_t{16}, good.size() - 1}) {
    CHECK_THROWS(owner.painter.merge({good.data(), length}), std::runtime_error);
  }
  for (std::size_t byte = 0; byte < 12; ++byte) {
    auto bad = good;
    bad[byte] = std::byte{200};
    CHECK_THROWS(owner.painter.merge(bad), std::runtime_error);
  }
  CHECK_THROWS(owner.painter.merge(Tile(view, 1, {records}).partial()), std::runtime_error);
}

TEST(image_several_painters_share_a_scene) {
  View view = small_view();
  view.objects = {ball(0, 0, 2)};
  const auto records = message(random_cloud(20000, 6), {}, view);
  const auto pixels = picture(view, {records});
  PreparedScene scene;
  scene.prepare(view);
  scene.render_all();
  const std::uint64_t version = scene.version();
  scene.prepare(view);
  CHECK(scene.version() == version);
  View brighter = view;
  brighter.exposure = 2;
  scene.prepare(brighter);
  CHECK(scene.version() != version);
  scene.prepare(view);
  Pieces messages;
  messages.begin(view);
  messages.add(records);
  TilePainter painters[2];
  for (TilePainter& painter : painters) painter.begin(scene);
  Pixels assembled(pixels.size());
  std::vector<Piece> pieces;
  for (int tile = scene.grid().tiles(); tile-- > 0;) {
    const Area area = scene.grid().area(tile);
    messages.collect(tile, pieces);
    TilePainter& painter = painters[tile % 2];
    painter.start(area);
    painter.paint(pieces);
    painter.show(assembled.data() + 3 * (area.y * view.width + area.x), static_cast<std::size_t>(3 * view.width));
  }
  CHECK(assembled == pixels);
}

}  // namespace motes::test_image_tile_painter
