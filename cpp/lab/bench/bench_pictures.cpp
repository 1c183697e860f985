#include "lab/bench/bench_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "comm/clock.h"
#include "image/post/bloom.h"
#include "image/post/bloom_tiles.h"
#include "image/project/projector.h"
#include "image/raster/pieces.h"
#include "image/raster/tile_painter.h"
#include "image/raycast/prepared_scene.h"
#include "lab/bench/bench_scene.h"
#include "simd/float_mode.h"

namespace motes::bench {
namespace {

constexpr double kDistance = 10;  // m, from the camera to the particles

image::View picture(int width, int height) {
  image::View view;
  view.width = width;
  view.height = height;
  view.camera.position = {0, 0, kDistance};
  view.bloom = 0.2f;
  return view;
}

using Planes = std::array<std::vector<float>, 3>;

// Returns points all over the picture, in random order.
Planes everywhere(const image::View& view, std::size_t count) {
  const double half = kDistance * std::tan(view.camera.fov_deg / 2 * std::numbers::pi / 180);
  const std::array<double, 3> reach{half * view.width / view.height, half, 0};
  Planes planes;
  std::uint64_t state = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    planes[axis].resize(count + kPadding);
    for (std::size_t i = 0; i < count; ++i) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      const double part = static_cast<double>(state >> 40) / (1 << 24);
      planes[axis][i] = static_cast<float>((2 * part - 1) * reach[axis]);
    }
  }
  return planes;
}

// Adds up the seconds of work between laps.
class Laps {
 public:
  void start() { last_ = comm::cpu_seconds(); }
  void add_to(double& seconds) {
    const double now = comm::cpu_seconds();
    seconds += now - last_;
    last_ = now;
  }

 private:
  double last_ = 0;
};

struct Seconds {
  double project = 0, paint = 0, start = 0, show = 0, keep = 0, spread = 0, mix = 0, bare = 0, save = 0, merge = 0;
};

// All tiles of one frame: drawn whole, as partial tiles by a rank with its own particles, and merged by their owner.
class Frame {
 public:
  Frame(std::size_t particles, int width, int height) : view_(picture(width, height)) {
    planes_ = everywhere(view_, particles);
    drawn_.count = particles;
    for (std::size_t axis = 0; axis < 3; ++axis) drawn_.position[axis] = planes_[axis].data();
    drawn_.alpha_of_all = 0.1f;
  }

  Seconds draw() {
    Seconds s;
    Laps laps;
    laps.start();
    projector_.project(drawn_, {}, view_, records_);
    laps.add_to(s.project);
    scene_.prepare(view_);
    painter_.begin(scene_);
    pieces_.begin(view_);
    pieces_.add(records_.bytes());
    shown_.resize(static_cast<std::size_t>(3 * image::kTile * image::kTile));
    std::vector<image::Area> tiles;
    for (int tile = 0; tile < scene_.grid().tiles(); ++tile) tiles.push_back(scene_.grid().area(tile));
    bloom_tiles_.begin(view_, tiles, 1);
    for (const image::Area& area : tiles) draw(area.tile, s, laps);
    laps.start();
    bloom_.begin(bloom_tiles_.plan());
    bloom_.add(bloom_tiles_);
    bloom_.spread();
    laps.add_to(s.spread);
    for (std::size_t i = 0; i < tiles.size(); ++i) bloom_tiles_.mix(i, bloom_.cells(), 0);
    laps.add_to(s.mix);
    return s;
  }

  std::size_t records() const { return image::RecordsView(records_.bytes()).count(); }

 private:
  void draw(int tile, Seconds& s, Laps& laps) {
    const image::Area area = scene_.grid().area(tile);
    scene_.render(tile);
    pieces_.collect(tile, of_tile_);
    laps.start();
    painter_.start_bare(area);
    laps.add_to(s.bare);
    painter_.paint(of_tile_);
    partial_.resize(0);
    laps.start();
    painter_.save_partial(partial_);
    laps.add_to(s.save);
    painter_.start(area);
    laps.start();
    painter_.merge({partial_.data(), partial_.size()});
    laps.add_to(s.merge);
    painter_.start(area);
    laps.add_to(s.start);
    painter_.paint(of_tile_);
    laps.add_to(s.paint);
    painter_.show(shown_.data(), 3 * static_cast<std::size_t>(area.width));
    laps.add_to(s.show);
    bloom_tiles_.keep(static_cast<std::size_t>(tile), painter_.light(), 0);
    laps.add_to(s.keep);
  }

  image::View view_;
  Planes planes_;
  image::Drawn drawn_;
  image::Projector projector_;
  image::Records records_;
  image::PreparedScene scene_;
  image::TilePainter painter_;
  image::Pieces pieces_;
  std::vector<image::Piece> of_tile_;
  image::Buffer partial_;
  std::vector<std::uint8_t> shown_;
  image::BloomTiles bloom_tiles_;
  image::Bloom bloom_;
};

}  // namespace

PictureBench picture_bench(std::size_t particles, int width, int height, int repeats) {
  if (particles < 1 || repeats < 1) throw std::invalid_argument("particles and repeats must be 1 or more");
  const simd::FloatMode mode;
  Frame frame(particles, width, height);
  frame.draw();  // the first one allocates memory
  const double pixels = static_cast<double>(width) * height, records = static_cast<double>(frame.records());
  std::vector<double> project, record, pixel, bloom, spread, partial;
  for (int i = 0; i < repeats; ++i) {
    const Seconds s = frame.draw();
    project.push_back(s.project / static_cast<double>(particles));
    record.push_back(s.paint / records);
    pixel.push_back((s.start + s.show) / pixels);
    bloom.push_back((s.keep + s.mix) / pixels);
    spread.push_back(s.spread / pixels);
    partial.push_back((s.bare + s.save + s.merge) / 2 / pixels);
  }
  const auto nanoseconds = [](const std::vector<double>& seconds) { return 1e9 * median(seconds); };
  return {nanoseconds(project), nanoseconds(record), nanoseconds(pixel),
          nanoseconds(bloom),   nanoseconds(spread), nanoseconds(partial)};
}

}  // namespace motes::bench
