#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "image/raycast/scenery.h"
#include "image/solids.h"
#include "image/test_image_reference_caster.h"
#include "image/test_image_scene.h"
#include "support/check.h"

namespace motes::test_image_scenery {
using namespace image_test;
using shapes::Kind;
using shapes::Shape;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Shape shape(Kind kind, std::initializer_list<float> numbers) {
  Shape s;
  s.kind = kind;
  int i = 0;
  for (const float n : numbers) s.number[i++] = n;
  return s;
}

bool close(const Vector& a, const Vector& b) {
  return std::fabs(a[0] - b[0]) + std::fabs(a[1] - b[1]) + std::fabs(a[2] - b[2]) < 1e-12;
}

}  // namespace

TEST(image_rays_meet_a_sphere) {
  const Shape s = shape(Kind::sphere, {1, 2, 3, 2, 0});
  Hit hit{};
  CHECK(intersect(s, {{1, 2, 10}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 5, 1e-12);
  CHECK(close(hit.normal, {0, 0, 1}));
  CHECK(intersect(s, {{1, 3, 10}, {0, 0, -2}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, (7 - std::sqrt(3.0)) / 2, 1e-12);
  CHECK(intersect(s, {{1, 2, 3}, {0, 1, 0}}, 0, kInfinity, hit));  // from inside
  CHECK_NEAR(hit.distance, 2, 1e-12);
  CHECK(close(hit.normal, {0, -1, 0}));
  CHECK(!intersect(s, {{1, 4.1, 10}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK(!intersect(s, {{1, 2, 10}, {0, 0, 1}}, 0, kInfinity, hit));
  CHECK(!intersect(s, {{1, 2, 10}, {0, 0, -1}}, 0, 4.9, hit));
}

TEST(image_rays_meet_a_box) {
  const Shape s = shape(Kind::box, {-1, -2, -3, 1, 2, 3});
  Hit hit{};
  CHECK(intersect(s, {{5, 0.5, 0.5}, {-1, 0, 0}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 4, 1e-12);
  CHECK(close(hit.normal, {1, 0, 0}));
  CHECK(intersect(s, {{0, 0, 0}, {0, 1, 0}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 2, 1e-12);
  CHECK(close(hit.normal, {0, -1, 0}));
  CHECK(intersect(s, {{3, 4, 0}, {-1, -1, 0}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 2, 1e-12);
  CHECK(!intersect(s, {{3, 6.5, 0}, {-1, -1, 0}}, 0, kInfinity, hit));
  CHECK(!intersect(s, {{5, 0, 0}, {1, 0, 0}}, 0, kInfinity, hit));
}

TEST(image_rays_meet_flat_shapes) {
  Hit hit{};
  const Shape plane = shape(Kind::plane, {0, -1, 0, 0, 2, 0});
  CHECK(intersect(plane, {{0, 1, 0}, {1, -1, 0}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 2, 1e-12);
  CHECK(close(hit.normal, {0, 1, 0}));
  CHECK(intersect(plane, {{0, -3, 0}, {0, 1, 0}}, 0, kInfinity, hit));
  CHECK(close(hit.normal, {0, -1, 0}));
  CHECK(!intersect(plane, {{0, 1, 0}, {1, 0, 0}}, 0, kInfinity, hit));
  CHECK(!intersect(plane, {{0, -1, 0}, {1, 0, 0}}, 0, kInfinity, hit));
  const Shape disc = shape(Kind::disc, {0, 0, 0, 0, 0, 3, 2, 1});
  CHECK(intersect(disc, {{1.5, 0, 4}, {0, 0, -2}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 2, 1e-12);
  CHECK(!intersect(disc, {{0.5, 0, 4}, {0, 0, -2}}, 0, kInfinity, hit));
  CHECK(!intersect(disc, {{2.1, 0, 4}, {0, 0, -2}}, 0, kInfinity, hit));
  const Shape rectangle = shape(Kind::rectangle, {0, 0, 0, 2, 0, 0, 1, 1, 0});
  CHECK(intersect(rectangle, {{2.9, 0.95, 1}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK(!intersect(rectangle, {{0.9, 0.95, 1}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK(!intersect(rectangle, {{1, -0.01, 1}, {0, 0, -1}}, 0, kInfinity, hit));
}

TEST(image_rays_meet_a_triangle) {
  const Shape s = shape(Kind::triangle, {0, 0, 0, 2, 0, 0, 0, 2, 0});
  Hit hit{};
  CHECK(intersect(s, {{0.9, 0.9, 3}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 3, 1e-12);
  CHECK(close(hit.normal, {0, 0, 1}));
  CHECK(!intersect(s, {{1.1, 1.1, 3}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK(!intersect(s, {{-0.1, 1, 3}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK(!intersect(s, {{0.5, 0.5, 3}, {0, 0, -1}}, 0, 2.9, hit));
}

TEST(image_rays_meet_a_cylinder_and_a_pipe) {
  const Shape solid = shape(Kind::cylinder, {1, 0, 0, 1, 4, 0, 2, 0});
  Hit hit{};
  CHECK(intersect(solid, {{1, 1, 7}, {0, 0, -2}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 2.5, 1e-12);
  CHECK(close(hit.normal, {0, 0, 1}));
  CHECK(intersect(solid, {{2, 9, 1}, {0, -1, 0}}, 0, kInfinity, hit));  // the lid
  CHECK_NEAR(hit.distance, 5, 1e-12);
  CHECK(close(hit.normal, {0, 1, 0}));
  CHECK(!intersect(solid, {{1, 4.1, 7}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK(!intersect(solid, {{3.1, 1, 7}, {0, 0, -1}}, 0, kInfinity, hit));
  const Shape pipe = shape(Kind::cylinder, {1, 0, 0, 1, 4, 0, 2, 1});
  CHECK(!intersect(pipe, {{1.5, 9, 0}, {0, -1, 0}}, 0, kInfinity, hit));  // through the bore
  CHECK(intersect(pipe, {{2.5, 9, 0}, {0, -1, 0}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 5, 1e-12);
  CHECK(intersect(pipe, {{1, 1, 0}, {1, 0, 0}}, 0, kInfinity, hit));  // from the bore
  CHECK_NEAR(hit.distance, 1, 1e-12);
  CHECK(close(hit.normal, {-1, 0, 0}));
}

TEST(image_rays_meet_a_cone) {
  const Shape s = shape(Kind::cone, {0, 2, 0, 0, 0, 0, 1, 0});
  Hit hit{};
  CHECK(intersect(s, {{0, 1, 5}, {0, 0, -1}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 4.5, 1e-12);
  CHECK(close(hit.normal, {0, 1 / std::sqrt(5.0), 2 / std::sqrt(5.0)}));
  CHECK(intersect(s, {{0.5, -3, 0}, {0, 1, 0}}, 0, kInfinity, hit));  // the base
  CHECK_NEAR(hit.distance, 3, 1e-12);
  CHECK(close(hit.normal, {0, -1, 0}));
  CHECK(intersect(s, {{0.5, 3, 0}, {0, -1, 0}}, 0, kInfinity, hit));
  CHECK_NEAR(hit.distance, 2, 1e-12);
  CHECK(intersect(s, {{0, 1, 1}, {0, -1, -0.5}}, 0, kInfinity, hit));  // along the far side: one root is infinite
  CHECK_NEAR(hit.distance, 0.5, 1e-12);
  CHECK(!intersect(s, {{0, 2.5, 5}, {0, 0, -1}}, 0, kInfinity, hit));  // no mirrored cone beyond the apex
  CHECK(!intersect(s, {{0.8, 1, 5}, {0, 0, -1}}, 0, kInfinity, hit));
}

TEST(image_shapes_without_a_surface_are_not_drawn) {
  CHECK_THROWS(check_solid("objects[0]", {shape(Kind::point, {0, 0, 0}), {}}), std::invalid_argument);
  CHECK_THROWS(check_solid("objects[0]", {shape(Kind::line, {0, 0, 0, 1, 1, 1}), {}}), std::invalid_argument);
  CHECK_THROWS(check_solid("objects[0]", {shape(Kind::blob, {0, 0, 0, 1}), {}}), std::invalid_argument);
  CHECK_THROWS(check_solid("objects[0]", {shape(Kind::sphere, {0, 0, 0, -1, 0}), {}}), std::invalid_argument);
}

TEST(image_scenery_has_depth_where_solids_are) {
  View view = small_view(200, 150);
  view.objects = {{shape(Kind::sphere, {0, 0, 0, 1, 0}), {1, 0.5f, 0.25f}}};
  Scenery scenery;
  scenery.prepare(view);
  scenery.render_all();
  const float depth = std::bit_cast<float>(scenery.depth(100, 75)[0]);
  CHECK(depth >= 9 && depth < 9 * 1.021);
  CHECK(scenery.depth(126, 126)[0] == Scenery::kNothing);
  CHECK(!scenery.occupied(3) && scenery.occupied(5));
  CHECK(scenery.light(126, 126)[1] == scenery.background()[1]);
  const std::uint32_t* light = scenery.light(100, 75);
  CHECK(light[0] > light[1] && light[1] > light[2]);
}

TEST(image_scenery_is_rendered_tile_by_tile) {
  View view = small_view(200, 150);
  view.objects = {{shape(Kind::sphere, {0, 0, 0, 1, 0}), {1, 0.5f, 0.25f}},
                  {shape(Kind::plane, {0, -1, 0, 0, 1, 0}), {1, 1, 1}}};
  Scenery all, some;
  all.prepare(view);
  all.render_all();
  some.prepare(view);
  for (const int tile : {5, 2, 9}) {
    CHECK(!some.rendered(tile));
    some.render(tile);
    CHECK(some.rendered(tile));
    CHECK(some.occupied(tile) == all.occupied(tile) && some.nearest(tile) == all.nearest(tile));
    for (int y = tile / 4 * 64; some.occupied(tile) && y < std::min(tile / 4 * 64 + 64, 150); ++y) {
      for (int x = tile % 4 * 64; x < std::min(tile % 4 * 64 + 64, 200); ++x) {
        CHECK(*some.depth(x, y) == *all.depth(x, y));
        CHECK(std::equal(some.light(x, y), some.light(x, y) + 3, all.light(x, y)));
      }
    }
  }
  CHECK(!some.rendered(0));
  CHECK_THROWS(some.render(12), std::invalid_argument);
  view.exposure = 2;
  some.prepare(view);
  CHECK(some.rendered(5) && some.version() == 1);
  view.camera.position[0] += 0.01;
  some.prepare(view);
  CHECK(!some.rendered(5) && some.version() == 2);
}

TEST(image_the_sun_throws_a_shadow) {
  View view = small_view(200, 150);
  view.camera.position = {0, 6, 10};
  view.objects = {{shape(Kind::plane, {0, 0, 0, 0, 1, 0}), {1, 1, 1}}};
  Scenery without, with;
  without.prepare(view);
  without.render_all();
  view.objects.push_back({shape(Kind::sphere, {0, 2, 0, 1, 0}), {1, 1, 1}});
  with.prepare(view);
  with.render_all();
  const auto darker = [&](int x, int y) { return *with.light(x, y) + kUnit / 4 < *without.light(x, y); };
  int shadow = 0;
  for (int y = 0; y < 150; ++y) {
    for (int x = 0; x < 200; ++x) shadow += darker(x, y);
  }
  CHECK(shadow > 100);
  CHECK(!darker(5, 140) && !darker(195, 140));
}

TEST(image_a_plane_fades_into_the_background) {
  View view = small_view(64, 300);
  view.camera.position = {0, 1, 10};
  view.camera.look_at = {0, 1, 0};
  view.objects = {{shape(Kind::plane, {0, 0, 0, 0, 1, 0}), {1, 1, 1}}};
  Scenery scenery;
  scenery.prepare(view);
  scenery.render_all();
  const auto light = [&](int y) { return static_cast<double>(*scenery.light(32, y)) / kUnit; };
  CHECK_NEAR(light(150), static_cast<double>(scenery.background()[0]) / kUnit, 0.025);
  for (int y = 299; y > 150; --y) CHECK(light(y - 1) <= light(y) + 1e-4);
}

TEST(image_objects_out_of_sight_are_left_out_only_where_nothing_of_them_shows) {
  View view = small_view(96, 64);
  view.camera.position = {0.3, 1, 6};
  view.camera.fov_deg = 75;
  for (int i = 0; i < 40; ++i) {
    const float x = static_cast<float>(i * 7 % 13) - 6, y = static_cast<float>(i * 5 % 9) - 4,
                z = static_cast<float>(i % 17) - 8;
    view.objects = {{shape(Kind::sphere, {x, y, z, 0.7f, 0}), {1, 1, 1}},
                    {shape(Kind::box, {y, x, -z, y + 1.5f, x + 0.2f, 0.5f - z + 1}), {1, 1, 0}},
                    {shape(Kind::rectangle, {z, y, x, 1, 0.5f, 0, 0, 0.5f, -2}), {1, 0, 1}},
                    {shape(Kind::triangle, {y, z, x, y + 1, z, x, y, z - 1, x + 1}), {0, 1, 0}},
                    {shape(Kind::cylinder, {-z, x, y, 0.5f - z, x + 1, y, 0.5f, 0.3f}), {0, 0, 1}},
                    {shape(Kind::cone, {-y, -x, z, -y, 1 - x, z + 1, 0.6f, 0}), {1, 0, 0}},
                    {shape(Kind::disc, {-x, y, z, 1, 0.2f, 1, 1.2f, 0.5f}), {0, 1, 1}}};
    if (view.objects[1].shape.number[2] > view.objects[1].shape.number[5]) continue;
    Caster whole(view), part(view);
    whole.aim(-1e6, -1e6, 1e6, 1e6);
    bool same = true;
    for (int top = 0; top < 64; top += 8) {
      for (int left = 0; left < 96; left += 8) {
        part.aim(left, top, left + 8, top + 8);
        for (int k = 0; k < 64; ++k) {
          const Sample a = whole.cast(left + k % 8 + 0.5, top + k / 8 + 0.5);
          const Sample b = part.cast(left + k % 8 + 0.5, top + k / 8 + 0.5);
          same &= a.depth == b.depth && a.surface == b.surface && a.light == b.light;
        }
      }
    }
    CHECK(same);
  }
}

}  // namespace motes::test_image_scenery
