// Point lights, light that objects emit, and the sun's direction.
#include <algorithm>
#include <cmath>

#include "image/light/daylight.h"
#include "image/raster/splat_lanes.h"
#include "image/raycast/scenery.h"
#include "image/test_image_scene.h"
#include "support/check.h"

namespace motes::test_image_lights {
using namespace image_test;
using shapes::Kind;

namespace {

Solid solid(Kind kind, std::initializer_list<float> numbers) {
  Solid made;
  made.shape.kind = kind;
  std::copy(numbers.begin(), numbers.end(), made.shape.number);
  return made;
}

// Returns a view of the ground from above, at night.
View night() {
  View view = small_view(129, 129);
  view.camera.position = {0, 10, 0};
  view.camera.look_at = {0, 0, 0};
  view.camera.up = {0, 0, -1};
  view.objects = {solid(Kind::plane, {0, 0, 0, 0, 1, 0})};
  view.sun = {0, -1, 0};
  view.background = {0, 0, 0};
  return view;
}

double light_at(Scenery& scenery, const View& view, int x, int y, std::size_t c = 0) {
  scenery.prepare(view);
  scenery.render_all();
  return static_cast<double>(scenery.light(x, y)[c]) / kUnit;
}
double light_at(const View& view, int x, int y, std::size_t c = 0) {
  Scenery scenery;
  return light_at(scenery, view, x, y, c);
}

}  // namespace

TEST(image_point_lights_follow_the_inverse_square) {
  View view = night();
  const double dark = light_at(view, 64, 64), clear = 1 - 100.0 / (100 + 2500);  // the light that passes the fog
  for (const double height : {0.5, 1.0, 2.0, 4.0}) {
    view.lights = {{{0, height, 0}, {1, 0.5f, 0}, 0.5f}};
    CHECK_NEAR(light_at(view, 64, 64) - dark, clear * 0.5 / (height * height), 2e-4 * (1 + 1 / height));
    CHECK_NEAR(light_at(view, 64, 64, 1) - dark, clear * 0.25 / (height * height), 2e-4 * (1 + 1 / height));
    CHECK_NEAR(light_at(view, 64, 64, 2), dark, 1e-4);
  }
  view.lights = {{{0, -1, 0}, {1, 1, 1}, 5}};  // under the ground
  CHECK_NEAR(light_at(view, 64, 64), dark, 1e-4);
}

TEST(image_bright_lights_keep_their_color) {
  View view = night();
  const double dark = light_at(view, 64, 64), clear = 1 - 100.0 / (100 + 2500);
  view.lights = {{{0, 1, 0}, {1, 0.5f, 0}, 100}};
  CHECK_NEAR(light_at(view, 64, 64) - dark, clear * 100, 0.05);
  CHECK_NEAR(light_at(view, 64, 64, 1) - dark, clear * 50, 0.05);
}

TEST(image_point_lights_add_up_and_throw_shadows) {
  View view = night();
  const double dark = light_at(view, 100, 64);
  view.lights = {{{0, 3, 0}, {1, 1, 1}, 1}};
  const double one = light_at(view, 100, 64) - dark;
  view.lights.push_back(view.lights[0]);
  CHECK_NEAR(light_at(view, 100, 64) - dark, 2 * one, 2e-4);
  view.lights.pop_back();
  // A ball between the light and the ground at the pixel; none between the ground and the camera.
  view.objects.push_back(solid(Kind::sphere, {0.67f, 1.5f, 0, 0.2f, 0}));
  view.objects[1].color = {0, 0, 0};
  CHECK(one > 0.01);
  double least = 1;
  for (int x = 85; x < 110; ++x) least = std::min(least, light_at(view, x, 64) - dark);
  CHECK_NEAR(least, 0, 2e-3);
  CHECK_NEAR(light_at(view, 20, 64) - dark, light_at(view, 108, 64) - dark, 1e-3);
}

TEST(image_a_lamp_shines_and_lets_its_light_out) {
  View view = night();
  view.objects.push_back(solid(Kind::sphere, {0, 1, 0, 0.25f, 0}));
  view.objects[1].color = {0.5f, 0.25f, 0.1f};
  const double ground = light_at(view, 100, 64);
  const double lamp = light_at(view, 64, 64);
  view.objects[1].light = 2;
  CHECK_NEAR(light_at(view, 64, 64) - lamp, 2 * 0.5, 0.05);
  CHECK_NEAR(light_at(view, 64, 64, 1), 0.5 * light_at(view, 64, 64), 0.01);
  CHECK_NEAR(light_at(view, 100, 64), ground, 1e-4);  // what shines does not light others
  view.lights = {{{0, 1, 0}, {1, 1, 1}, 2}};          // in the middle of the lamp
  CHECK(light_at(view, 100, 64) > ground + 0.02);
}

TEST(image_the_sun_may_stand_anywhere) {
  View view = night();
  const double dark = light_at(view, 64, 64);
  view.sun = {0, 2, 0};
  const double noon = light_at(view, 64, 64);
  view.sun = {1.7320508, 1, 0};
  const double evening = light_at(view, 64, 64);
  CHECK(noon > dark + 0.5);
  CHECK_NEAR((evening - dark) / (noon - dark), 0.5, 1e-3);
}

TEST(image_spheres_without_a_sun_have_the_light_of_the_sky) {
  View view = night();
  view.sun = {0, 0, 0};
  const Daylight daylight(view);
  for (const double x : daylight.toward_sun()) CHECK(x == 0);
  CHECK_NEAR(daylight.shade({0, 0, 1}), kSky, 1e-12);  // seen from above
}

namespace {

std::size_t rays = 0;

void count_rays(const CastView& view, const float* x, const float* y, std::size_t count, const Surfaces& to) {
  rays += count;
  cast_lanes().cast(view, x, y, count, to);
}

}  // namespace

TEST(image_moving_lights_need_no_rays_from_the_camera) {
  CastLanes counting = cast_lanes();
  counting.cast = count_rays;
  View view = night();
  view.objects.push_back(solid(Kind::box, {-1, 0, -1, 1, 1, 1}));
  view.lights = {{{2, 3, 1}, {1, 1, 1}, 4}};
  Scenery scenery(counting);
  const double before = light_at(scenery, view, 20, 64);
  CHECK(rays > 129 * 129);
  rays = 0;
  view.lights[0].position = {-4, 2, 0};
  view.background = {0.1f, 0, 0};
  view.objects[0].color = {0.5f, 1, 1};
  const double after = light_at(scenery, view, 20, 64);
  CHECK(rays == 0 && after != before);
  CHECK(after == light_at(view, 20, 64));  // as in a new rendering
  Scenery anew;
  anew.prepare(view);
  anew.render_all();
  bool same = true;
  for (int y = 0; y < 129; ++y) {
    for (int x = 0; x < 129; ++x) same &= std::equal(anew.light(x, y), anew.light(x, y) + 3, scenery.light(x, y));
  }
  CHECK(same);
  view.camera.fov_deg = 41;
  light_at(scenery, view, 20, 64);
  CHECK(rays > 129 * 129);
}

}  // namespace motes::test_image_lights
