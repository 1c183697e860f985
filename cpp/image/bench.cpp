#include "image/bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "image/canvas.h"
#include "image/projector.h"
#include "image/records.h"
#include "simd/isa.h"

namespace motes::image {
namespace {

constexpr std::size_t kSystems = 8;
constexpr std::size_t kPadding = 16;

// A small multiplicative generator: the scene must be the same everywhere; the quality of the numbers matters little.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 1) {}
  double operator()(double low, double high) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (static_cast<double>(state_ >> 40) * (1.0 / 16777216.0));
  }

 private:
  std::uint64_t state_;
};

struct System {
  BufferOf<float> planes[3];
  std::size_t count = 0;
  Color color{};
  float alpha = 1;

  Drawn drawn() const {
    Drawn d;
    d.count = count;
    for (std::size_t axis = 0; axis < 3; ++axis) d.position[axis] = planes[axis].data();
    d.color_of_all = color;
    d.alpha_of_all = alpha;
    return d;
  }
};

Vector snowflake(Draws& draw) { return {draw(-12.75, 12.75), draw(-7.3, 7.3), draw(-10, 6)}; }

Vector drop(Draws& draw, std::size_t system) {
  const double age = draw(0, 2);
  const double out = draw(0, 1.2), turn_x = draw(-1, 1), turn_z = draw(-1, 1);
  const double reach = std::sqrt(turn_x * turn_x + turn_z * turn_z) + 1e-9;
  const double rise = draw(8.5, 9.8);
  const double foot = (static_cast<double>(system) - 3.5) * 2.2;
  return {foot + out * age * turn_x / reach, -5 + rise * age - 4.905 * age * age, out * age * turn_z / reach};
}

System make_system(std::size_t index, std::size_t count, bool fountain) {
  System s;
  s.count = count;
  const auto i = static_cast<float>(index);
  s.color = fountain ? Color{0.45f + 0.02f * i, 0.65f, 0.95f} : Color{0.95f, 0.95f, 1.0f - 0.01f * i};
  s.alpha = fountain ? 0.1f : 0.3f;
  for (auto& plane : s.planes) plane.resize(count + kPadding);
  Draws draw(index + 1);
  for (std::size_t p = 0; p < count; ++p) {
    const Vector position = fountain ? drop(draw, index) : snowflake(draw);
    for (std::size_t axis = 0; axis < 3; ++axis) s.planes[axis].data()[p] = static_cast<float>(position[axis]);
  }
  return s;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double now_ms() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(since).count();
}

}  // namespace

RenderBench render_bench(std::size_t particles, int width, int height, int pixels, int frames, bool fountain) {
  if (particles < 1 || frames < 1) throw std::invalid_argument("particles and frames must be at least 1");
  View view;
  view.width = width;
  view.height = height;
  view.camera.position = {0, 0, 20};
  view.camera.fov_deg = 40;
  view.background = {0.004f, 0.006f, 0.014f};
  const Sprite sprite{Sprite::Kind::disc, pixels};

  std::vector<System> systems;
  for (std::size_t i = 0; i < kSystems; ++i) {
    systems.push_back(make_system(i, particles / kSystems + (i < particles % kSystems ? 1 : 0), fountain));
  }
  std::vector<Records> records(kSystems);
  std::vector<std::uint8_t> picture;
  Projector projector;
  Canvas canvas;
  std::vector<double> whole, project;
  for (int frame = -1; frame < frames; ++frame) {  // the first one warms up memory and tables
    const double start = now_ms();
    for (std::size_t i = 0; i < kSystems; ++i) projector.project(systems[i].drawn(), sprite, view, records[i]);
    const double projected = now_ms();
    canvas.begin(view);
    for (const Records& r : records) canvas.add(r.bytes());
    picture.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    canvas.finish(picture);
    const double end = now_ms();
    if (frame < 0) continue;
    whole.push_back(end - start);
    project.push_back(projected - start);
  }

  RenderBench result;
  result.particles = particles;
  result.width = width;
  result.height = height;
  result.pixels = pixels;
  result.frames = frames;
  result.isa = simd::name(simd::isa());
  for (const Records& r : records) {
    result.records += RecordsView(r.bytes()).count();
    result.bytes += r.bytes().size();
  }
  result.ms_per_frame = median(whole);
  result.ms_per_frame_min = *std::min_element(whole.begin(), whole.end());
  result.ms_project = median(project);
  for (std::size_t i = 0; i < whole.size(); ++i) whole[i] -= project[i];
  result.ms_splat = median(whole);
  return result;
}

}  // namespace motes::image
