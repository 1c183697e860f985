// Records outside the bands around a tile's surfaces are not tested, which must not show.
#include "image/raster/splat_lanes.h"

#include <cstring>
#include <numeric>

#include "image/test_image_wide_scene.h"
#include "support/check.h"

namespace motes::image_test::depth_bands {
namespace {

// Selects every record.
std::size_t find_all(const BandSearch&, const unsigned char*, std::size_t count, std::uint32_t* numbers) {
  std::iota(numbers, numbers + count, 0u);
  return count;
}

std::vector<std::byte> settled_by(const SplatLanes& lanes, const PaintedTile& tile, const Piece& piece) {
  Behind behind;
  behind.start(tile.scene.scenery(), tile.area, lanes);
  const Piece changed = behind.settled(piece);
  return {changed.records, changed.records + piece.count * piece.brush->record_bytes()};
}

// Returns a view of a floor up to the horizon, a ball and a box, in a picture whose sides are not whole tiles.
View solid_view() {
  View view = small_view(201, 149);
  Solid floor, ball, box;
  floor.shape.kind = shapes::Kind::plane;
  const std::vector<float> plane{0, -1, 0, 0, 1, 0}, sphere{0.5f, 0.2f, 1, 1.2f, 0}, corners{-3, -2, -4, -1, 2, 2};
  std::copy(plane.begin(), plane.end(), floor.shape.number);
  ball.shape.kind = shapes::Kind::sphere;
  std::copy(sphere.begin(), sphere.end(), ball.shape.number);
  box.shape.kind = shapes::Kind::box;
  std::copy(corners.begin(), corners.end(), box.shape.number);
  view.objects = {floor, ball, box};
  return view;
}

// Returns a random depth, half of the time close to the surface at the record's centre.
float near_depth(test::Dice& dice, const PaintedTile& tile, float x, float y) {
  const Scenery& scenery = tile.scene.scenery();
  const auto pixel = [](float at, int first, int count) {
    return std::clamp(static_cast<int>(std::floor(at)), first, first + count - 1);
  };
  const float surface = *scenery.surface_depth(pixel(x, tile.area.x, tile.area.width),  //
                                               pixel(y, tile.area.y, tile.area.height));
  if (surface < 1e6f && dice.coin()) return surface * (1 + dice.between(-0.04f, 0.08f) * dice.between(0, 1));
  return dice.between(2, 40);
}

// Returns random records that reach into the tile.
Batch random_records(const Sprite& sprite, Layout layout, const View& view, const PaintedTile& tile,
                     std::uint64_t seed) {
  Batch batch(sprite, layout, view);
  test::Dice dice(seed);
  const Grid& grid = tile.scene.grid();
  for (int i = 0; i < 4000; ++i) {
    const auto size = static_cast<std::uint16_t>(dice.below(40) < 39 ? 2 + dice.below(1000) : dice.below(30000));
    const float reach =
        1 + 0.5f * static_cast<float>(of_fixed_size(layout) ? batch.brush.footprint_pixels() : (size >> kSizeBits));
    const float x = static_cast<float>(tile.area.x) + dice.between(-reach, static_cast<float>(tile.area.width) + reach);
    const float y =
        static_cast<float>(tile.area.y) + dice.between(-reach, static_cast<float>(tile.area.height) + reach);
    const float depth = near_depth(dice, tile, x, y);
    const float right = x - 0.5f * static_cast<float>(view.width), down = y - 0.5f * static_cast<float>(view.height);
    if (layout == Layout::wide) {
      WideRecord r = wide_record(right, down, 1, depth);
      r.size = size;
      batch.put(r);
      continue;
    }
    const RecordForm form = image::form(layout);
    const int bits = of_fixed_size(layout) ? grid.sub_bits() : grid.far_bits();
    const std::int16_t at[2] = {static_cast<std::int16_t>(std::lround(right * static_cast<float>(1 << bits))),
                                static_cast<std::int16_t>(std::lround(down * static_cast<float>(1 << bits)))};
    std::array<std::byte, 32> r{};
    std::memcpy(r.data(), at, sizeof at);
    std::memcpy(r.data() + form.depth, &depth, sizeof depth);
    if (form.size != 0) std::memcpy(r.data() + form.size, &size, sizeof size);
    batch.bytes.insert(batch.bytes.end(), r.begin(), r.begin() + form.bytes);
  }
  return batch;
}

}  // namespace

TEST(image_records_outside_the_bands_around_surfaces_stay_as_they_are) {
  const View view = solid_view();
  for (const SplatLanes* lanes : usable_splat_lanes()) {
    SplatLanes thorough = *lanes;
    thorough.find_in_bands = find_all;
    std::size_t deeper = 0;
    for (int tile = 0; tile < 12; ++tile) {
      const PaintedTile painted(view, tile, *lanes);
      for (const Layout layout : {Layout::deep, Layout::deep_sized, Layout::deep_moving, Layout::wide}) {
        for (const int pixels : {1, 5, 8}) {
          Sprite sprite = wide_sprite(Kind::disc, Blend::add);
          if (of_fixed_size(layout)) sprite.pixels = pixels;
          const Batch batch = random_records(sprite, layout, view, painted, static_cast<std::uint64_t>(pixels + tile));
          const auto quick = settled_by(*lanes, painted, batch.piece());
          CHECK(quick == settled_by(thorough, painted, batch.piece()));
          if (quick != batch.bytes) ++deeper;
        }
      }
    }
    CHECK(deeper > 60);
  }
}

}  // namespace motes::image_test::depth_bands
