#include "lab/bench/bench_image.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/enumerators.h"
#include "image/post/canvas.h"
#include "image/project/projector.h"
#include "image/project/records.h"
#include "lab/bench/bench_scene.h"
#include "simd/isa.h"

namespace motes::bench {
namespace {

using namespace image;

constexpr std::size_t kSystems = 8;

// A linear congruential generator: the scene must be the same everywhere; the quality of the numbers matters little.
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

struct FrameTime {
  double whole, project;
};

// Draws the systems in one form, with its own buffers, and collects the times.
class Drawing {
 public:
  Drawing(std::string name, const Sprite& sprite, const View& view)
      : name_(std::move(name)), sprite_(sprite), view_(view), records_(kSystems) {
    projection_.any_depth = anything_hides(view, {&sprite, 1});
    projection_.dt = 1;
  }

  FrameTime draw(const std::vector<System>& systems) {
    const double start = cpu_now_ms();
    for (std::size_t i = 0; i < kSystems; ++i) {
      Drawn drawn = systems[i].drawn();
      drawn.size_of_all = kSize;
      drawn.velocity_of_all = {kStreak * 0.6f, kStreak * -0.8f, 0};
      projector_.project(drawn, sprite_, view_, records_[i], projection_);
    }
    const double projected = cpu_now_ms();
    canvas_.begin(view_);
    for (const Records& r : records_) canvas_.add(r.bytes());
    picture_.resize(static_cast<std::size_t>(view_.width) * static_cast<std::size_t>(view_.height) * 3);
    canvas_.finish(picture_);
    return {cpu_now_ms() - start, projected - start};
  }

  void measure(const std::vector<System>& systems, double additive_ms) {
    const FrameTime time = draw(systems);
    whole.push_back(time.whole);
    project.push_back(time.project);
    ratio.push_back(time.whole / (additive_ms > 0 ? additive_ms : time.whole));
  }

  RenderRow row() const {
    RenderRow row;
    row.name = name_;
    row.kind = base::name_of(sprite_.kind);
    row.blend = base::name_of(sprite_.blend);
    row.pixels = sprite_.kind == Sprite::Kind::point ? 1 : sprite_.pixels;
    row.ms_per_frame = median(whole);
    row.ms_project = median(project);
    row.ratio = median(ratio);
    return row;
  }
  const std::vector<Records>& records() const { return records_; }

  std::vector<double> whole, project, ratio;

 private:
  // Velocity in m/s whose streak is 10 pixels long in the middle of the box: frames of 1 s, 1080 pixels high.
  static constexpr float kStreak = 0.135f;
  // Size in metres that covers 5 pixels in the middle of the box.
  static constexpr float kSize = 0.0674f;

  std::string name_;
  Sprite sprite_;
  View view_;
  Projection projection_;
  Projector projector_;
  std::vector<Records> records_;
  Canvas canvas_;
  std::vector<std::uint8_t> picture_;
};

View bench_view(int width, int height) {
  View view;
  view.width = width;
  view.height = height;
  view.camera.position = {0, 0, 20};
  view.camera.fov_deg = 40;
  view.background = {0.004f, 0.006f, 0.014f};
  return view;
}

// Adds balls in the middle of the box, in every tile: they hide about a quarter of the particles.
View with_solids(View view) {
  for (int row = -3; row <= 3; ++row) {
    for (int column = -6; column <= 6; ++column) {
      Solid ball;
      ball.shape.kind = shapes::Kind::sphere;
      ball.shape.number[0] = 2 * static_cast<float>(column);
      ball.shape.number[1] = 2 * static_cast<float>(row);
      ball.shape.number[2] = -2;
      ball.shape.number[3] = 0.8f;
      view.objects.push_back(ball);
    }
  }
  return view;
}

Sprite leaf(int pixels) {
  meshes::Picture picture;
  picture.width = picture.height = 32;
  for (int i = 0; i < 32 * 32; ++i) {
    const int x = 2 * (i % 32) - 31, y = 2 * (i / 32) - 31;
    const auto alpha = static_cast<std::uint8_t>(x * x + 3 * y * y < 900 ? 255 : 0);
    for (const std::uint8_t v : {std::uint8_t{90}, std::uint8_t{160}, std::uint8_t{60}, alpha})
      picture.rgba.push_back(v);
  }
  Sprite sprite;
  sprite.kind = Sprite::Kind::image;
  sprite.pixels = pixels;
  sprite.picture = keep(picture);
  return sprite;
}

struct Form {
  const char* name;
  Sprite sprite;
  View view;
};

// Lists the forms to measure; times are relative to the first.
std::vector<Form> all_forms(const View& view, int pixels) {
  std::vector<Form> all;
  Sprite disc;
  disc.pixels = pixels;
  Sprite sphere = disc, point = disc;
  sphere.kind = Sprite::Kind::sphere;
  point.kind = Sprite::Kind::point;
  View open = view;
  open.shutter = 1;
  const View open_solids = with_solids(view);
  const auto add = [&](const char* name, Sprite sprite, Sprite::Blend blend, const View& seen) {
    sprite.blend = blend;
    all.push_back({name, sprite, seen});
  };
  using Blend = Sprite::Blend;
  add("disc", disc, Blend::add, view);
  add("disc, tested by depth", disc, Blend::add, open_solids);
  Sprite soft = disc;
  soft.softness = 0.5f;
  add("disc, soft", soft, Blend::add, open_solids);
  add("disc", disc, Blend::alpha, view);
  add("disc", disc, Blend::opaque, view);
  add("point", point, Blend::add, view);
  add("point", point, Blend::alpha, view);
  add("point", point, Blend::opaque, view);
  add("sphere", sphere, Blend::add, view);
  add("sphere", sphere, Blend::alpha, view);
  add("sphere", sphere, Blend::opaque, view);
  for (const Blend blend : {Blend::add, Blend::alpha, Blend::opaque}) add("image", leaf(pixels), blend, view);
  Sprite sized = disc;
  sized.of_height = static_cast<float>(pixels) / static_cast<float>(view.height);
  add("disc, size from the picture's height", sized, Blend::add, view);
  // 5 pixels in the middle of the box, 20 m from the camera.
  Sprite metres = disc;
  metres.pixels = 0;
  add("disc, size in metres", metres, Blend::add, view);
  add("disc, streak of 10 pixels", disc, Blend::add, open);
  add("point, streak of 10 pixels", point, Blend::add, open);
  View bright = view;
  bright.bloom = 0.2f;
  add("disc, with bloom", disc, Blend::add, bright);
  return all;
}

// Time limit for each form, ms: no frame starts after it.
constexpr double kEnoughMs = 2000;

// Measures forms one after another, since the records of one may take a hundred megabytes.
std::vector<RenderRow> measured(const std::vector<Form>& forms, const std::vector<System>& systems, int frames) {
  std::vector<RenderRow> rows(1);
  for (std::size_t i = 1; i < forms.size(); ++i) {
    Drawing additive(forms[0].name, forms[0].sprite, forms[0].view);
    Drawing form(forms[i].name, forms[i].sprite, forms[i].view);
    additive.draw(systems);  // warms up memory and tables
    form.draw(systems);
    double spent_ms = 0;
    for (int frame = 0; frame < frames && spent_ms < kEnoughMs; ++frame) {
      additive.measure(systems, 0);
      form.measure(systems, additive.whole.back());
      spent_ms += form.whole.back();
    }
    rows.push_back(form.row());
    rows[0] = additive.row();
  }
  return rows;
}

}  // namespace

RenderBench render_bench(std::size_t particles, int width, int height, int pixels, int frames, bool fountain) {
  if (particles < 1 || frames < 1) throw std::invalid_argument("particles and frames must be at least 1");
  const View view = bench_view(width, height);
  std::vector<System> systems;
  for (std::size_t i = 0; i < kSystems; ++i) {
    systems.push_back(make_system(i, particles / kSystems + (i < particles % kSystems ? 1 : 0), fountain));
  }
  Sprite sprite;
  sprite.pixels = pixels;
  Drawing discs("disc", sprite, view);
  discs.draw(systems);
  for (int frame = 0; frame < frames; ++frame) discs.measure(systems, 0);

  RenderBench result;
  result.particles = particles;
  result.width = width;
  result.height = height;
  result.pixels = pixels;
  result.frames = frames;
  result.isa = simd::name(simd::isa());
  for (const Records& r : discs.records()) {
    result.records += RecordsView(r.bytes()).count();
    result.bytes += r.bytes().size();
  }
  result.ms_per_frame = median(discs.whole);
  result.ms_per_frame_min = *std::min_element(discs.whole.begin(), discs.whole.end());
  result.ms_project = median(discs.project);
  std::vector<double> splat = discs.whole;
  for (std::size_t i = 0; i < splat.size(); ++i) splat[i] -= discs.project[i];
  result.ms_splat = median(splat);
  result.rows = measured(all_forms(view, pixels), systems, frames);
  return result;
}

}  // namespace motes::bench
