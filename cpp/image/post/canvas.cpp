#include "image/post/canvas.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "base/invalid_argument.h"

namespace motes::image {

std::size_t Canvas::at(const Area& area) const {
  return static_cast<std::size_t>(area.y) * row_lanes() + static_cast<std::size_t>(area.x) * 3;
}

// Calls work(tile, area, worker).
template <class Work>
void Canvas::each_tile(const Work& work) {
  pool_->run(static_cast<std::size_t>(scene_.grid().tiles()), [&](std::size_t part, std::size_t worker) {
    const int tile = static_cast<int>(part);
    work(tile, scene_.grid().area(tile), worker);
  });
}

void Canvas::begin(const View& view, bool keep_linear, threads::Pool& pool, const ShadowGrids* shadows) {
  pool_ = &pool;
  scene_.prepare(view, static_cast<std::size_t>(pool.threads()), shadows);
  scene_.render_all(pool);
  workers_.begin(scene_, pool.threads());
  scenery_pixels_.resize(size());
  shown_versions_.resize(static_cast<std::size_t>(scene_.grid().tiles()));
  messages_.begin(view);
  layers_.begin(view);
  keep_linear_ = keep_linear;
  light_kept_ = false;
}

Pixels Canvas::finish() {
  Pixels pixels(size());
  finish(pixels);
  return pixels;
}

void Canvas::finish(std::span<std::uint8_t> pixels) {
  if (!scene_.prepared()) throw std::logic_error("Canvas::finish before begin");
  if (pixels.size() != size()) throw base::InvalidArgument("pixels", "be height * width * 3 bytes");
  const bool liquids = liquids_.begin(scene_.view(), messages_), bloom = scene_.view().bloom > 0;
  if (keep_linear_ || liquids) light_.begin(scene_.grid());
  if (bloom) begin_bloom();
  if (liquids) add_liquids();
  each_tile([&](int tile, const Area& area, std::size_t worker) {
    std::vector<Piece>& pieces = workers_[worker].pieces;
    messages_.collect(tile, pieces);
    if (liquids) std::erase_if(pieces, is_liquid);
    if (liquids && liquids_.near(tile)) {
      paint_behind_liquids(area, workers_[worker]);
    } else {
      paint(area, worker, pixels.data());
    }
  });
  if (liquids) finish_liquids(pixels.data());
  if (bloom) show_bloom(pixels.data());
  light_kept_ = keep_linear_;
  messages_.begin(scene_.view());
}

// Paints the worker's pieces, and shows the tile unless its glow is to be added.
void Canvas::paint(const Area& area, std::size_t worker, std::uint8_t* pixels) {
  TileWorker& by = workers_[worker];
  const bool bloom = scene_.view().bloom > 0;
  if (by.pieces.empty() && !bloom && !keep_linear_ && scene_.view().layers == 0) {
    return show_scenery(area, by.painter, pixels);
  }
  by.painter.start(area);
  by.painter.paint(by.pieces);
  keep_or_show(by.painter.light(), area, worker, pixels);
  layers_.keep(by.painter, by.pieces, area);
}

// Ends the light of a tile: keeps it for the glow, or shows it.
void Canvas::keep_or_show(const TileLight& light, const Area& area, std::size_t worker, std::uint8_t* pixels) {
  if (scene_.view().bloom > 0) {
    bloom_tiles_.keep(static_cast<std::size_t>(area.tile), light, worker);
  } else {
    show(workers_[worker].painter, light, area, pixels);
  }
}

void Canvas::show(const TilePainter& painter, const TileLight& light, const Area& area, std::uint8_t* pixels) {
  if (keep_linear_ && light.first != light_.at(area)) light.copy_to(light_.at(area), light_.row_lanes());
  painter.show(light, pixels + at(area), row_lanes());
}

void Canvas::begin_bloom() {
  std::vector<Area> tiles;
  for (int tile = 0; tile < scene_.grid().tiles(); ++tile) tiles.push_back(scene_.grid().area(tile));
  bloom_tiles_.begin(scene_.view(), std::move(tiles), pool_->threads());
}

// Spreads the light that bloom_tiles_ keeps, and shows it.
void Canvas::show_bloom(std::uint8_t* pixels) {
  bloom_.begin(bloom_tiles_.plan());
  bloom_.add(bloom_tiles_);
  bloom_.spread(*pool_);
  each_tile([&](int tile, const Area& area, std::size_t worker) {
    const TileLight light = bloom_tiles_.mix(static_cast<std::size_t>(tile), bloom_.cells(), worker);
    show(workers_[worker].painter, light, area, pixels);
  });
}

void Canvas::add_liquids() {
  each_tile([&](int tile, const Area& area, std::size_t worker) {
    std::vector<Piece>& pieces = workers_[worker].pieces;
    messages_.collect(tile, pieces);
    liquids_.add(area, pieces);
  });
  liquids_.added();
}

void Canvas::paint_behind_liquids(const Area& area, TileWorker& by) {
  by.painter.start(area);
  by.painter.paint(by.pieces);
  liquids_.take(by.painter, light_.at(area), light_.row_lanes());
  layers_.keep(by.painter, by.pieces, area);
  liquids_.keep_front(area, by.pieces, by.painter);
}

void Canvas::finish_liquids(std::uint8_t* pixels) {
  liquids_.finish(light_.at({}), *pool_);
  if (scene_.view().layers != 0) {
    liquids_.each_pixel([&](int x, int y, float depth) { layers_.cover(x, y, depth); });
  }
  each_tile([&](int tile, const Area& area, std::size_t worker) {
    if (!liquids_.near(tile)) return;
    keep_or_show({light_.at(area), light_.row_lanes(), area.width, area.height, area.x, area.y}, area, worker, pixels);
  });
}

// Shows a tile without particles. Its pixels are kept while the scene stays the same.
void Canvas::show_scenery(const Area& area, TilePainter& painter, std::uint8_t* pixels) {
  std::uint64_t& shown = shown_versions_[static_cast<std::size_t>(area.tile)];
  if (shown != scene_.version()) {
    painter.start(area);
    painter.paint({});
    painter.show(scenery_pixels_.data() + at(area), row_lanes());
    shown = scene_.version();
  }
  for (int y = 0; y < area.height; ++y) {
    const std::size_t row = at(area) + static_cast<std::size_t>(y) * row_lanes();
    std::memcpy(pixels + row, scenery_pixels_.data() + row, static_cast<std::size_t>(area.width) * 3);
  }
}

std::vector<float> Canvas::linear() const {
  if (!light_kept_) throw std::logic_error("Canvas::linear: the frame was begun without keep_linear");
  return light_.linear();
}

}  // namespace motes::image
