#include "image/canvas.h"

#include <cstring>
#include <stdexcept>

namespace motes::image {

std::size_t Canvas::at(const Area& area) const {
  return static_cast<std::size_t>(area.y) * row_lanes() + static_cast<std::size_t>(area.x) * 3;
}

void Canvas::begin(const View& view, bool keep_linear) {
  scene_.prepare(view);
  scene_.render_all();
  painter_.begin(scene_);
  if (shown_version_ != scene_.version()) render_scenery();
  messages_.begin(view);
  keep_linear_ = keep_linear;
  light_kept_ = false;
}

std::vector<std::uint8_t> Canvas::finish() {
  std::vector<std::uint8_t> pixels(size());
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
  for (int tile = 0; tile < scene_.grid().tiles(); ++tile) {
    const Area area = scene_.grid().area(tile);
    if (messages_.collect(tile, pieces_) == 0) {
      copy_scenery(area, pixels.data());
      continue;
    }
    painter_.start(area);
    painter_.paint(pieces_);
    painter_.show(pixels.data() + at(area), row_lanes());
  }
}

void Canvas::finish_as_a_whole(std::span<std::uint8_t> pixels) {
  light_.begin(scene_.grid());
  layers_.begin(scene_.view());
  for (int tile = 0; tile < scene_.grid().tiles(); ++tile) {
    const Area area = scene_.grid().area(tile);
    messages_.collect(tile, pieces_);
    painter_.start(area);
    painter_.paint(pieces_);
    painter_.sums(light_.at(area), light_.row_lanes());
    layers_.keep(painter_, pieces_, area);
  }
  light_.finish(scene_, pixels);
  light_kept_ = keep_linear_;
}

void Canvas::render_scenery() {
  scenery_pixels_.resize(size());
  for (int tile = 0; tile < scene_.grid().tiles(); ++tile) {
    const Area area = scene_.grid().area(tile);
    painter_.start(area);
    painter_.show(scenery_pixels_.data() + at(area), row_lanes());
  }
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
