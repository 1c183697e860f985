#include "image/post/layers.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace motes::image {
namespace {

void read(TilePainter& painter, std::span<const Piece> pieces, std::uint8_t bit, float* to, std::size_t row_floats) {
  if (bit == kDepthLayer) painter.depth(to, row_floats);
  if (bit == kAlphaLayer) painter.alpha(pieces, to, row_floats);
  if (bit == kVelocityLayer) painter.velocity(pieces, to, row_floats);
}

}  // namespace

void Layers::begin(const View& view) {
  width_ = static_cast<std::size_t>(view.width);
  for (Plane& plane : planes_) {
    const bool wanted = (view.layers & plane.bit) != 0;
    plane.all.resize(wanted ? plane.values * width_ * static_cast<std::size_t>(view.height) : 0);
  }
}

float* Layers::at(Plane& plane, const Area& area) const {
  return plane.all.data() +
         plane.values * (static_cast<std::size_t>(area.y) * width_ + static_cast<std::size_t>(area.x));
}

void Layers::keep(TilePainter& painter, std::span<const Piece> pieces, const Area& area) {
  for (Plane& plane : planes_) {
    if (plane.all.empty()) continue;
    read(painter, pieces, plane.bit, at(plane, area), plane.values * width_);
  }
}

void Layers::send(const View& view, TilePainter& painter, std::span<const Piece> pieces, const Area& area,
                  base::Bytes& out) {
  for (const Plane& plane : Layers().planes_) {
    if ((view.layers & plane.bit) == 0) continue;
    const std::size_t row = plane.values * static_cast<std::size_t>(area.width);
    std::vector<float> values(row * static_cast<std::size_t>(area.height));
    read(painter, pieces, plane.bit, values.data(), row);
    out.put_raw(values.data(), values.size() * sizeof(float));
  }
}

void Layers::take(const Area& area, base::Reader& in) {
  for (Plane& plane : planes_) {
    if (plane.all.empty()) continue;
    const std::size_t row = plane.values * static_cast<std::size_t>(area.width);
    float* to = at(plane, area);
    for (int y = 0; y < area.height; ++y, to += plane.values * width_) {
      std::memcpy(to, in.take(row * sizeof(float)).data(), row * sizeof(float));
    }
  }
}

void Layers::cover(int x, int y, float depth) {
  for (Plane& plane : planes_) {
    if (plane.all.empty()) continue;
    const float value = plane.bit == kDepthLayer ? depth : plane.bit == kAlphaLayer ? 1.0f : 0.0f;
    std::fill_n(at(plane, {0, x, y, 1, 1}), plane.values, value);
  }
}

void Layers::keep_blank(const Area& area) {
  for (Plane& plane : planes_) {
    if (plane.all.empty()) continue;
    const float nothing = plane.bit == kDepthLayer ? std::numeric_limits<float>::infinity() : 0;
    float* to = at(plane, area);
    for (int y = 0; y < area.height; ++y, to += plane.values * width_) {
      std::fill_n(to, plane.values * static_cast<std::size_t>(area.width), nothing);
    }
  }
}

const std::vector<float>& Layers::layer(std::uint8_t bit) const {
  for (const Plane& plane : planes_) {
    if (plane.bit == bit && !plane.all.empty()) return plane.all;
  }
  throw std::logic_error("the last picture has no such layer: its view does not request it");
}

}  // namespace motes::image
