// A picture's content does not depend on its resolution, nor its light on motion.
#include <array>
#include <cmath>
#include <vector>

#include "image/post/canvas.h"
#include "image/project/projector.h"
#include "image/test_image_scene.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_image_resolutions {
using namespace image_test;
using test::Dice;

namespace {

View dark_view(int width, int height) {
  View view = small_view(width, height);
  view.background = {0, 0, 0};
  view.linear = true;
  return view;
}

// Returns a picture's light: linear RGB.
std::vector<float> light_of(const Drawn& drawn, const Sprite& sprite, const View& view, double dt = 0) {
  Projector projector;
  Records records;
  Projection projection;
  projection.dt = dt;
  projector.project(drawn, sprite, view, records, projection);
  Canvas canvas;
  canvas.begin(view, true);
  canvas.add(records.bytes());
  canvas.finish();
  return canvas.linear();
}

double sum(const std::vector<float>& light) {
  double total = 0;
  for (const float x : light) total += x;
  return total;
}

// Returns the light per pixel of `side` x `side` equal parts of a picture.
std::vector<double> parts(const std::vector<float>& light, int width, int height, int side) {
  std::vector<double> mean(static_cast<std::size_t>(side * side), 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto part = static_cast<std::size_t>(y * side / height * side + x * side / width);
      const std::size_t at = static_cast<std::size_t>(y * width + x) * 3;
      mean[part] +=
          (light[at] + light[at + 1] + light[at + 2]) * static_cast<float>(side * side) / (3.0 * width * height);
    }
  }
  return mean;
}

struct Scene {
  Cloud cloud;
  std::vector<float> size;

  Scene(std::size_t count, float least, float most) : cloud(count, true), size(count + 16) {
    Dice dice(5);
    for (std::size_t i = 0; i < count; ++i) {
      const float place[] = {dice.between(-5, 5), dice.between(-3, 3), dice.between(-5, 5)};
      cloud.place(i, place[0], place[1], place[2]);
      size[i] = dice.between(least, most);
      cloud.alpha[i] = 0.1f;
    }
  }
  Drawn drawn() const {
    Drawn d = cloud.drawn();
    d.size = size.data();
    return d;
  }
};

}  // namespace

TEST(image_brightness_does_not_depend_on_the_resolution) {
  const float sizes[][2] = {{0.002f, 0.01f}, {0.01f, 0.05f}, {0.05f, 0.4f}, {0.002f, 0.4f}};
  for (const auto& [least, most] : sizes) {
    const Scene scene(20000, least, most);
    const Sprite sprite{Sprite::Kind::disc, 0};
    const auto large = light_of(scene.drawn(), sprite, dark_view(1920, 1080));
    const auto small = light_of(scene.drawn(), sprite, dark_view(320, 180));
    const auto here = parts(large, 1920, 1080, 4), there = parts(small, 320, 180, 4);
    for (std::size_t i = 0; i < here.size(); ++i) CHECK_NEAR(there[i] / here[i], 1, 0.03);
  }
}

TEST(image_sizes_in_parts_of_the_height_look_the_same_at_every_resolution) {
  const Scene scene(3000, 1, 1);
  for (const float part : {0.001f, 0.004f, 0.02f, 0.3f}) {
    Sprite sprite;
    sprite.of_height = part;
    const auto large = light_of(scene.drawn(), sprite, dark_view(1920, 1080));
    const auto small = light_of(scene.drawn(), sprite, dark_view(320, 180));
    const auto here = parts(large, 1920, 1080, 2), there = parts(small, 320, 180, 2);
    for (std::size_t i = 0; i < here.size(); ++i) CHECK_NEAR(there[i] / here[i], 1, 0.03);
  }
}

TEST(image_sizes_in_parts_of_the_height_do_not_depend_on_pixels) {
  const Scene scene(3000, 1, 1);
  const View view = dark_view(320, 180);
  for (const float part : {0.02f, 0.1f}) {  // a fixed size, and any size
    std::vector<std::vector<float>> light;
    for (const int pixels : {5, 1, 0}) {
      Sprite sprite;
      sprite.of_height = part;
      sprite.pixels = pixels;
      light.push_back(light_of(scene.drawn(), sprite, view));
    }
    CHECK(light[1] == light[0]);
    CHECK(light[2] == light[0]);
  }
}

TEST(image_light_does_not_depend_on_the_place_in_a_pixel) {
  View view = dark_view(160, 90);
  view.camera.fov_deg = 1;  // spheres are seen from one direction, wherever they are
  std::vector<Sprite> sprites;
  for (const float pixels : {2.25f, 2.5f, 3.5f, 4.5f, 9.3f}) {
    for (const Sprite::Kind kind : {Sprite::Kind::disc, Sprite::Kind::sphere}) {
      Sprite sprite{kind};
      sprite.of_height = pixels / 90;
      sprites.push_back(sprite);
    }
  }
  meshes::Picture white;
  white.width = white.height = 128;
  white.rgba.assign(std::size_t{4} * 128 * 128, 255);
  sprites.push_back({Sprite::Kind::image, 5});
  sprites.back().sheet()->picture = meshes::keep(std::move(white));
  const double metre = 45 / std::tan(0.5 * 3.14159265358979323846 / 180) / 10;  // in pixels
  for (const Sprite& sprite : sprites) {
    double first = 0;
    for (int step = 0; step < 100; ++step) {  // over the edge between two tiles, with the picture's corner first
      const double x = -21 + 0.1 * step, y = -24.5 + (sprite.is(Sprite::Kind::image) ? 0 : 0.11 * step);
      Cloud one(1);
      one.place(0, static_cast<float>(x / metre), static_cast<float>(y / metre), 0);
      Drawn drawn = one.drawn();
      drawn.up_of_all = {1, 1, 0};
      const double light = sum(light_of(drawn, sprite, view));
      if (step == 0) first = light;
      CHECK_NEAR(light / first, 1, sprite.is(Sprite::Kind::sphere) ? 0.005 : 5e-4);
    }
  }
}

TEST(image_streaks_keep_their_light) {
  const View still = dark_view(640, 360);
  View open = still;
  open.shutter = 0.5f;
  std::vector<Sprite> sprites = {{Sprite::Kind::point, 1}};
  for (const Sprite::Kind kind : {Sprite::Kind::disc, Sprite::Kind::sphere}) {
    for (const int pixels : {0, 1, 2, 3, 5, 8, 15, 30}) sprites.push_back({kind, pixels});
    for (const float pixels : {0.5f, 1.3f, 2.25f, 2.5f, 2.75f, 3.5f, 4.5f, 7.7f, 14.5f}) {
      Sprite sprite{kind};
      sprite.of_height = pixels / static_cast<float>(still.height);
      sprites.push_back(sprite);
    }
  }
  for (const Sprite& sprite : sprites) {
    for (const float speed : {0.5f, 4.0f, 40.0f}) {
      Cloud one(1);
      one.place(0, 0.3f, 0.2f, 0);
      Drawn drawn = one.drawn();
      drawn.size_of_all = 0.1f;
      drawn.velocity_of_all = {speed, -0.7f * speed, 0};
      const double there = sum(light_of(drawn, sprite, open, 1.0 / 24));
      // In the middle of the streak: a sphere's light depends on the direction in which it is seen.
      Cloud middle(1);
      const float way = 0.25f * speed / 24;
      middle.place(0, 0.3f - way, 0.2f + 0.7f * way, 0);
      Drawn same = middle.drawn();
      same.size_of_all = drawn.size_of_all;
      CHECK_NEAR(there / sum(light_of(same, sprite, still)), 1, 0.01);
    }
  }
}

}  // namespace motes::test_image_resolutions
