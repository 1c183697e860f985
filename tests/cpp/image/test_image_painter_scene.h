// Handmade records, for tests of a tile's painter.
#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>
#include <vector>

#include "image/raster/behind.h"
#include "image/raster/brush.h"
#include "image/raster/ordered.h"
#include "image/raster/tile_painter.h"
#include "image/test_image_scene.h"
#include "support/isas.h"

namespace motes::image_test {

/// Records of one brush, as bytes.
struct Batch {
  Brush brush;
  std::vector<std::byte> bytes;

  Batch(const Sprite& sprite, Layout layout, const View& view) : brush(sprite, layout, view) {}
  std::size_t count() const { return bytes.size() / brush.record_bytes(); }
  template <class Record>
  void put(const Record& record) {
    bytes.resize(bytes.size() + sizeof record);
    std::memcpy(bytes.data() + bytes.size() - sizeof record, &record, sizeof record);
  }
  template <class Record>
  Record record(std::size_t i) const {
    Record r;
    std::memcpy(&r, bytes.data() + i * brush.record_bytes(), sizeof r);
    return r;
  }
  Piece piece(std::size_t first = 0, std::size_t count = ~std::size_t{0}) const {
    return {&brush, bytes.data() + first * brush.record_bytes(), std::min(count, this->count() - first)};
  }
  void shuffle(test::Dice& dice) {
    const std::size_t size = brush.record_bytes();
    for (std::size_t i = count(); i > 1; --i) {
      const std::size_t other = dice.below(i);
      std::swap_ranges(bytes.begin() + static_cast<std::ptrdiff_t>((i - 1) * size),
                       bytes.begin() + static_cast<std::ptrdiff_t>(i * size),
                       bytes.begin() + static_cast<std::ptrdiff_t>(other * size));
    }
  }
};

/// Returns particles all over a view of at most 256 pixels, with few different depths, so that many are equal.
inline Batch random_batch(const Sprite& sprite, const View& view, std::size_t count, std::uint64_t seed) {
  Batch batch(sprite, Layout::deep, view);
  test::Dice dice(seed);
  for (std::size_t i = 0; i < count; ++i) {
    DeepRecord r{};
    r.x = static_cast<std::int16_t>(dice.between(-8.5f, 8.5f) * static_cast<float>(view.width));
    r.y = static_cast<std::int16_t>(dice.between(-8.5f, 8.5f) * static_cast<float>(view.height));
    for (auto& c : r.color) c = static_cast<std::uint8_t>(dice.below(256));
    r.alpha = static_cast<std::uint8_t>(dice.below(256));
    const float depth = dice.coin() ? dice.between(5, 15) : 5 + static_cast<float>(dice.below(10));
    std::memcpy(&r.depth, &depth, 4);
    batch.put(r);
  }
  return batch;
}

inline float depth_of(const DeepRecord& r) {
  float depth;
  std::memcpy(&depth, &r.depth, 4);
  return depth;
}

/// One tile and the painter that paints it.
struct PaintedTile {
  PreparedScene scene;
  TilePainter painter;
  Area area;

  explicit PaintedTile(const View& view, int tile = 0, const SplatLanes& lanes = splat_lanes(),
                       const WideLanes& wide = wide_lanes())
      : painter(lanes, wide) {
    scene.prepare(view);
    scene.render(tile);
    painter.begin(scene);
    area = scene.grid().area(tile);
    painter.start(area);
  }
  std::vector<float> paint(const std::vector<Piece>& pieces) {
    painter.paint(pieces);
    return light();
  }
  std::vector<float> light() const { return light_of(painter, area); }
  std::vector<float> depth() const {
    std::vector<float> depths(static_cast<std::size_t>(area.width * area.height));
    painter.depth(depths.data(), static_cast<std::size_t>(area.width));
    return depths;
  }
  /// Returns the depths behind which particles are hidden: for solids, a little behind their surfaces.
  std::vector<float> hides() const {
    std::vector<float> depths = depth();
    const Scenery& scenery = scene.scenery();
    for (int y = 0; scenery.occupied(area.tile) && y < area.height; ++y) {
      const std::uint32_t* wall = scenery.depth(area.x, area.y + y);
      const float* surface = scenery.surface_depth(area.x, area.y + y);
      float* row = depths.data() + static_cast<std::ptrdiff_t>(y) * area.width;
      for (int x = 0; x < area.width; ++x) {
        if (row[x] == surface[x]) row[x] = std::bit_cast<float>(wall[x]);
      }
    }
    return depths;
  }
  std::vector<std::byte> partial(const std::vector<Piece>& pieces) {
    painter.start_bare(area);
    painter.paint(pieces);
    Buffer saved;
    painter.save_partial(saved);
    return {saved.data(), saved.data() + saved.size()};
  }
};

/// Returns the batches as the tile's painter draws them: those close behind a surface are deeper
/// (image/raster/behind.h).
inline std::vector<Batch> settled(const std::vector<Batch>& batches, const PaintedTile& tile) {
  Behind behind;
  behind.start(tile.scene.scenery(), tile.area, splat_lanes());
  std::vector<Batch> changed = batches;
  for (Batch& batch : changed) {
    const Piece piece = behind.settled(batch.piece());
    batch.bytes.assign(piece.records, piece.records + batch.bytes.size());
  }
  return changed;
}

/// Returns all of the batches, each shuffled and cut in two, in random order.
inline std::vector<Piece> shuffled_pieces(std::vector<Batch>& batches, test::Dice& dice) {
  std::vector<Piece> pieces;
  for (Batch& b : batches) {
    b.shuffle(dice);
    const std::size_t cut = dice.below(b.count());
    pieces.push_back(b.piece(0, cut));
    pieces.push_back(b.piece(cut));
  }
  for (std::size_t i = pieces.size(); i > 1; --i) std::swap(pieces[i - 1], pieces[dice.below(i)]);
  return pieces;
}

/// Returns a ball that hides part of what `random_batch` makes.
inline Solid ball(float x, float y, float radius) {
  Solid solid;
  solid.shape.kind = shapes::Kind::sphere;
  solid.shape.number[0] = x;
  solid.shape.number[1] = y;
  solid.shape.number[3] = radius;
  return solid;
}

inline View painter_view(bool with_solid = false) {
  View view = small_view(120, 90);
  if (with_solid) view.objects = {ball(0, 0, 2), ball(2.5f, 1, 0.5f)};
  return view;
}

}  // namespace motes::image_test
