#include "image/canvas.h"

#include <cstring>
#include <stdexcept>

namespace motes::image {

std::size_t Canvas::at(const Area& area) const {
  return static_cast<std::size_t>(area.y) * row_lanes() + static_cast<std::size_t>(area.x) * 3;
}

// Calls work(tile, area, worker).
template <class Work>
void Canvas::each_tile(const Work& work) {
  pool_->run(static_cast<std::size_t>(scene_.grid().tiles()), [&](std::size_t part, std::size_t worker) {
    const int tile = static_cast<int>(part);
    work(tile, scene_.grid().area(tile), workers_[worker]);
  });
}

void Canvas::begin(const View& view, bool keep_linear, threads::Pool& pool) {
  pool_ = &pool;
  scene_.prepare(view, static_cast<std::size_t>(pool.threads()));
  scene_.render_all(pool);
  workers_.begin(scene_, pool.threads());
  if (shown_version_ != scene_.version()) render_scenery();
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
  if (pixels.size() != size()) throw std::invalid_argument("pixels must be height * width * 3 bytes");
  if (PictureLight::needed(scene_.view(), keep_linear_)) {
    finish_as_a_whole(pixels);
  } else {
    finish_by_tiles(pixels);
  }
  messages_.begin(scene_.view());
}

void Canvas::finish_by_tiles(std::span<std::uint8_t> pixels) {
  each_tile([&](int tile, const Area& area, TileWorker& by) {
    if (messages_.collect(tile, by.pieces) == 0) return copy_scenery(area, pixels.data());
    by.painter.start(area);
    by.painter.paint(by.pieces);
    by.painter.show(pixels.data() + at(area), row_lanes());
  });
}

void Canvas::finish_as_a_whole(std::span<std::uint8_t> pixels) {
  light_.begin(scene_.grid());
  each_tile([&](int tile, const Area& area, TileWorker& by) {
    messages_.collect(tile, by.pieces);
    by.painter.start(area);
    by.painter.paint(by.pieces);
    by.painter.sums(light_.at(area), light_.row_lanes());
    layers_.keep(by.painter, by.pieces, area);
  });
  light_.finish(scene_, pixels, *pool_);
  light_kept_ = keep_linear_;
}

void Canvas::render_scenery() {
  scenery_pixels_.resize(size());
  each_tile([&](int, const Area& area, TileWorker& by) {
    by.painter.start(area);
    by.painter.show(scenery_pixels_.data() + at(area), row_lanes());
  });
  shown_version_ = scene_.version();
}

void Canvas::copy_scenery(const Area& area, std::uint8_t* pixels) const {
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
