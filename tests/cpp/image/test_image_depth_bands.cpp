// Records close behind a surface become deeper as the formula says; bounds that let most records be skipped do not
// show.
#include "image/raster/splat_lanes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "image/test_image_wide_scene.h"
#include "support/check.h"

namespace motes::image_test::depth_bands {
namespace {

std::vector<std::byte> settled_by(const SplatLanes& lanes, const PaintedTile& tile, const Piece& piece) {
  Behind behind;
  behind.start(tile.scene.scenery(), tile.area, lanes);
  const Piece changed = behind.settled(piece);
  return {changed.records, changed.records + piece.count * piece.brush->record_bytes()};
}

// The formula of settle_lanes.h for one record after the other, without bounds.
class Formula {
 public:
  explicit Formula(const PaintedTile& tile) : scenery_(tile.scene.scenery()), area_(tile.area) {}

  std::vector<std::byte> settled(const Batch& batch) const {
    std::vector<std::byte> records = batch.bytes;
    const RecordForm form = batch.brush.form();
    for (std::byte* r = records.data(); r != records.data() + records.size(); r += form.bytes) {
      float depth = 0;
      std::memcpy(&depth, r + form.depth, sizeof depth);
      depth = settled(center_of(batch.brush, r), depth, batch.brush.sprite().is(Kind::disc));
      std::memcpy(r + form.depth, &depth, sizeof depth);
    }
    return records;
  }

 private:
  struct Center {
    float x, y, blur, radius;
  };

  Center center_of(const Brush& brush, const std::byte* record) const {
    const Grid& grid = scenery_.grid();
    const float left = 0.5f * static_cast<float>(grid.width), top = 0.5f * static_cast<float>(grid.height);
    if (of_fixed_size(brush.layout())) {
      const float unit = 1.0f / static_cast<float>(1 << grid.sub_bits());
      std::int16_t at[2];
      std::memcpy(at, record, sizeof at);
      return {left + (static_cast<float>(at[0]) + 0.5f) * unit, top + (static_cast<float>(at[1]) + 0.5f) * unit, unit,
              0.5f * static_cast<float>(brush.footprint_pixels())};
    }
    const WideRecord r = image::wide_record(brush.form(), grid.far_bits(), record);
    constexpr float kPixel = 1.0f / (1 << kWideBits);
    return {left + static_cast<float>(r.x) * kPixel, top + static_cast<float>(r.y) * kPixel,
            1.0f / static_cast<float>(1 << (is_wide(brush.layout()) ? kWideBits : grid.far_bits())),
            0.5f / (1 << kSizeBits) * static_cast<float>(r.size)};
  }

  // Returns the depth from which on surfaces in reach of a record at this pixel hide it.
  float high(int column, int row, float radius) const {
    const int reach = radius > 8 ? kBlocks : 1;
    float most = 0;
    for (int y = 0; y < area_.height; ++y) {
      for (int x = 0; x < area_.width; ++x) {
        if (std::abs((x >> kBlockBits) - (column >> kBlockBits)) > reach) continue;
        if (std::abs((y >> kBlockBits) - (row >> kBlockBits)) > reach) continue;
        const float hides = std::bit_cast<float>(*scenery_.depth(area_.x + x, area_.y + y));
        if (hides < std::numeric_limits<float>::infinity()) most = std::max(most, hides);
      }
    }
    return most;
  }

  float settled(const Center& center, float depth, bool flat) const {
    const auto nearest = [](float at, int first, int count) {
      return std::clamp(static_cast<int>(std::floor(at)) - first, 0, count - 1);
    };
    const int column = nearest(center.x, area_.x, area_.width), row = nearest(center.y, area_.y, area_.height);
    const int x = area_.x + column, y = area_.y + row;
    const float surface = *scenery_.surface_depth(x, y), hides = std::bit_cast<float>(*scenery_.depth(x, y));
    if (surface == std::numeric_limits<float>::max() ||
        depth < 0.9f * std::bit_cast<float>(scenery_.nearest(area_.tile)) ||
        (flat && depth > high(column, row, center.radius))) {
      return depth;
    }
    const float right = center.x - (static_cast<float>(x) + 0.5f), down = center.y - (static_cast<float>(y) + 0.5f);
    const Scenery::Eye& eye = scenery_.eye();
    const std::array<float, 3> n = normal(column, row);
    const auto towards = [&](const std::array<float, 3>& way) {
      return -(n[0] * way[0] + n[1] * way[1] + n[2] * way[2]);
    };
    const float by_column = towards(eye.right) * eye.pixel, by_row = -towards(eye.up) * eye.pixel;
    const float ahead = towards(eye.forward) +
                        (by_column * (static_cast<float>(x) + 0.5f - 0.5f * static_cast<float>(scenery_.grid().width)) +
                         by_row * (static_cast<float>(y) + 0.5f - 0.5f * static_cast<float>(scenery_.grid().height)));
    const float there = ahead + by_column * right + by_row * down;
    if (!(there > 0)) return depth;
    const float at = surface * (ahead / there), slope = (std::abs(by_column) + std::abs(by_row)) / there;
    const float margin = slope * center.blur + 1.0f / 4096;
    const float bent = bend(column, row) * (right * right + down * down) * eye.pixel / (there * there);
    if (!(depth > at * (margin + bent + 1))) return depth;
    const float reach = center.radius + 1, left = 1 - slope * reach;
    const float deepening = left * 4096 > 1 ? 1 / left : 4096;
    return std::max(depth, at * (deepening * (hides / surface) + reach * eye.pixel));
  }

  const float* surfaces(int column, int row) const {
    return scenery_.surface_depth(area_.x, area_.y) + row * kSurfaceStride + column;
  }
  std::array<float, 3> normal(int column, int row) const {
    const std::ptrdiff_t plane = scenery_.surface_plane(area_.tile);
    const float* from = surfaces(column, row);
    return {from[plane], from[2 * plane], from[3 * plane]};
  }

  float bend(int column, int row) const {
    const auto object = [&](int x, int y) {
      return object_of(std::bit_cast<std::uint32_t>(surfaces(x, y)[4 * scenery_.surface_plane(area_.tile)]));
    };
    const std::array<float, 3> own = normal(column, row);
    float most = 0;
    for (const auto& [across, below] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int x = std::clamp(column + across, 0, area_.width - 1), y = std::clamp(row + below, 0, area_.height - 1);
      if (object(x, y) != object(column, row)) continue;
      const std::array<float, 3> other = normal(x, y);
      most = std::max(most, std::abs(other[0] - own[0]) + std::abs(other[1] - own[1]) + std::abs(other[2] - own[2]));
    }
    return most;
  }

  const Scenery& scenery_;
  Area area_;
};

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

TEST(image_records_close_behind_surfaces_become_as_deep_as_the_formula_says) {
  const View view = solid_view();
  for (const SplatLanes* lanes : usable_splat_lanes()) {
    std::size_t deeper = 0;
    for (int tile = 0; tile < 12; ++tile) {
      const PaintedTile painted(view, tile, *lanes);
      const Formula formula(painted);
      for (const Layout layout : {Layout::deep, Layout::deep_sized, Layout::deep_moving, Layout::wide}) {
        for (const int pixels : {1, 5, 8}) {
          Sprite sprite = wide_sprite(pixels == 5 ? Kind::sphere : Kind::disc, Blend::add);
          if (of_fixed_size(layout)) sprite.pixels = pixels;
          const Batch batch = random_records(sprite, layout, view, painted, static_cast<std::uint64_t>(pixels + tile));
          const auto settled = settled_by(*lanes, painted, batch.piece());
          CHECK(settled == formula.settled(batch));
          if (settled != batch.bytes) ++deeper;
        }
      }
    }
    CHECK(deeper > 60);
  }
}

}  // namespace motes::image_test::depth_bands
