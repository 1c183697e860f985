// Wide records and their pictures.
#pragma once

#include <cmath>
#include <numeric>
#include <vector>

#include "image/camera.h"
#include "image/test_image_painter_scene.h"

namespace motes::image_test {

using Blend = Sprite::Blend;
using Kind = Sprite::Kind;

inline Sprite wide_sprite(Kind kind, Blend blend, meshes::AssetKey picture = 0) {
  Sprite s{kind};
  s.blend = blend;
  s.pixels = kind == Kind::point ? 1 : 0;
  if (Sheet* sheet = s.sheet()) sheet->picture = picture;
  return s;
}

// Returns a record at (x, y) pixels from the centre of the image.
inline WideRecord wide_record(double x, double y, double diameter, double depth = 10) {
  WideRecord r{};
  r.x = static_cast<std::int32_t>(std::lround(x * 256));
  r.y = static_cast<std::int32_t>(std::lround(y * 256));
  for (auto& c : r.color) c = 255;
  r.alpha = 255;
  const auto z = static_cast<float>(depth);
  std::memcpy(&r.depth, &z, 4);
  r.size = static_cast<std::uint16_t>(std::lround(diameter * 64));
  r.light = kAllLight;
  return r;
}

inline View wide_view(int width, int height) {
  View view = small_view(width, height);
  view.background = {0, 0, 0};
  return view;
}

// Returns all tiles of a picture, rows from top to bottom.
inline std::vector<float> whole_picture(const View& view, const std::vector<Piece>& pieces) {
  const auto row = static_cast<std::size_t>(3 * view.width);
  std::vector<std::uint32_t> light(row * static_cast<std::size_t>(view.height));
  PreparedScene scene;
  scene.prepare(view);
  scene.render_all();
  TilePainter painter;
  painter.begin(scene);
  for (int tile = 0; tile < scene.grid().tiles(); ++tile) {
    const Area area = scene.grid().area(tile);
    painter.start(area);
    painter.paint(pieces);
    painter.light().copy_to(light.data() + 3 * (area.y * view.width + area.x), row);
  }
  return linear_of(light);
}

inline std::vector<float> picture_of(const View& view, const Sprite& sprite, const WideRecord& record) {
  Batch one(sprite, Layout::wide, view);
  one.put(record);
  return whole_picture(view, {one.piece()});
}

inline double sum(const std::vector<float>& light) { return std::accumulate(light.begin(), light.end(), 0.0); }

// Returns an image of 16 x 8 texels: the upper half red and opaque, the lower half green and half transparent.
inline meshes::AssetKey two_colors() {
  meshes::Picture p;
  p.width = 16;
  p.height = 8;
  for (int i = 0; i < 128; ++i) {
    const bool upper = i < 64;
    for (const int c : {upper ? 255 : 0, upper ? 0 : 255, 0, upper ? 255 : 128}) {
      p.rgba.push_back(static_cast<std::uint8_t>(c));
    }
  }
  return keep(p);
}

inline std::vector<const WideLanes*> usable_wide_lanes() { return test::runnable<WideLanes>(MOTES_BUILDS(wide_lanes)); }

}  // namespace motes::image_test
