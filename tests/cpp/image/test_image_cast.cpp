// The scenery's vectors of rays, compared with a caster of single rays in double precision; the same bits in all
// builds.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/vectors.h"
#include "image/camera.h"
#include "image/raster/splat_lanes.h"
#include "image/raycast/scenery.h"
#include "image/test_image_meshes.h"
#include "image/test_image_reference_caster.h"
#include "image/test_image_scene.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_image_cast {
using namespace image_test;
using shapes::Kind;
using test::Dice;

namespace {

Vector somewhere(Dice& dice) { return {dice.between(-3, 3), dice.between(0, 3), dice.between(-3, 3)}; }

Solid random_solid(Dice& dice) {
  Solid solid;
  float* n = solid.shape.number;
  const Vector at = somewhere(dice),
               to = operator+(at, {dice.between(-1, 1), dice.between(0.2f, 2), dice.between(-1, 1)});
  const auto put = [&](const Vector& v, int i) {
    for (std::size_t c = 0; c < 3; ++c) n[i + static_cast<int>(c)] = static_cast<float>(v[c]);
  };
  put(at, 0);
  put(to, 3);
  n[6] = dice.between(0.2f, 1);
  constexpr Kind kKinds[] = {Kind::sphere,   Kind::box,      Kind::disc, Kind::rectangle,
                             Kind::triangle, Kind::cylinder, Kind::cone};
  solid.shape.kind = kKinds[dice.below(7)];
  switch (solid.shape.kind) {
    case Kind::sphere: n[3] = dice.between(0.2f, 1), n[4] = 0; break;
    case Kind::box:
      for (int i = 0; i < 3; ++i) n[i + 3] = n[i] + dice.between(0.2f, 2);
      break;
    case Kind::disc: put({dice.between(-1, 1), 1, dice.between(-1, 1)}, 3), n[7] = dice.coin() ? 0.1f : 0; break;
    case Kind::rectangle: put({1.5, 0.2, 0.3}, 3), put({-0.2, 0.3, dice.between(1, 2)}, 6); break;
    case Kind::triangle: put(somewhere(dice), 6); break;
    default: n[7] = dice.below(3) == 0 ? n[6] : dice.coin() ? 0.5f * n[6] : 0;
  }
  for (float& c : solid.color) c = dice.between(0.1f, 1);
  return solid;
}

View random_view(std::uint64_t seed, int width = 200, int height = 150) {
  Dice dice(seed);
  View view;
  view.width = width;
  view.height = height;
  view.camera.position = {dice.between(-6, 6), dice.between(0.5f, 6), dice.between(4, 9)};
  view.camera.look_at = {0, 1, 0};
  view.camera.fov_deg = dice.between(25, 75);
  view.background = {0.05f, 0.06f, 0.09f};
  Solid ground;
  ground.shape.kind = Kind::plane;
  ground.shape.number[4] = 1;
  ground.color = {0.6f, 0.6f, 0.6f};
  view.objects.push_back(ground);
  for (int i = 0; i < 6; ++i) view.objects.push_back(random_solid(dice));
  return view;
}

Scenery rendered(const View& view, const image::CastLanes& lanes = image::cast_lanes()) {
  Scenery scenery(lanes);
  scenery.prepare(view);
  scenery.render_all();
  return scenery;
}

int tile_at(const View& view, int x, int y) { return y / 64 * ((view.width + 63) / 64) + x / 64; }

// Returns what a pixel shows, 0..1, roughly in sRGB's steps.
double shown(double linear) { return std::sqrt(std::min(linear, 1.0)); }
double shown(const Scenery& scenery, const View& view, int x, int y, std::size_t c) {
  const bool occupied = scenery.occupied(tile_at(view, x, y));
  const std::uint32_t light = occupied ? scenery.light(x, y)[c] : scenery.background()[c];
  return shown(static_cast<double>(light) / kUnit);
}

// Returns the mean difference of two pictures of a view, in 1/255.
template <class A, class B>
double difference(const View& view, const A& a, const B& b) {
  double sum = 0;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) sum += std::fabs(a(x, y, c) - b(x, y, c));
    }
  }
  return 255 * sum / (3.0 * view.width * view.height);
}

// A whole picture by single rays; edges are where the surfaces of neighbouring pixels differ.
class Reference {
 public:
  explicit Reference(const View& view) : view_(view), caster_(view) {
    caster_.aim(-1, -1, view.width + 1, view.height + 1);
    for (int y = 0; y < view.height; ++y) {
      for (int x = 0; x < view.width; ++x) centers_.push_back(caster_.cast(x + 0.5, y + 0.5));
    }
  }
  const Sample& center(int x, int y) const { return centers_[static_cast<std::size_t>(y * view_.width + x)]; }
  bool edge(int x, int y) const {
    const std::uint32_t here = center(x, y).surface;
    return surface(x - 1, y) != here || surface(x, y - 1) != here || surface(x + 1, y) != here ||
           surface(x, y + 1) != here;
  }
  double operator()(int x, int y, std::size_t c) const {
    if (!edge(x, y)) return shown(center(x, y).light[c]);
    return shown((caster_.cast(x + 0.375, y + 0.125).light[c] + caster_.cast(x + 0.875, y + 0.375).light[c] +
                  caster_.cast(x + 0.625, y + 0.875).light[c] + caster_.cast(x + 0.125, y + 0.625).light[c]) /
                 4);
  }

 private:
  // Returns the surface at a pixel, which may be just outside the picture.
  std::uint32_t surface(int x, int y) const {
    const bool inside = x >= 0 && y >= 0 && x < view_.width && y < view_.height;
    return inside ? center(x, y).surface : caster_.cast(x + 0.5, y + 0.5).surface;
  }

  View view_;
  Caster caster_;
  std::vector<Sample> centers_;
};

std::vector<const image::CastLanes*> usable_cast_lanes() {
  return test::runnable<image::CastLanes>(MOTES_BUILDS(cast_lanes));
}

Solid sphere_at_origin(float radius) {
  Solid solid;
  solid.shape.kind = Kind::sphere;
  solid.shape.number[3] = radius;
  return solid;
}

}  // namespace

TEST(image_scenery_is_what_single_rays_see) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const View view = random_view(seed);
    const Scenery scenery = rendered(view);
    const Reference reference(view);
    const auto vectors = [&](int x, int y, std::size_t c) { return shown(scenery, view, x, y, c); };
    CHECK(difference(view, vectors, reference) < 0.05);
    int apart = 0;
    for (int y = 0; y < view.height; ++y) {
      for (int x = 0; x < view.width; ++x) {
        const double want = reference.center(x, y).depth;
        const bool occupied = scenery.occupied(tile_at(view, x, y));
        const double got =
            occupied ? double{std::bit_cast<float>(*scenery.depth(x, y))} : std::numeric_limits<double>::infinity();
        apart += !(got == want || std::fabs(got - want) < 2e-5 * want + 1e-6 * want * want);
      }
    }
    CHECK(apart <= 12);  // pixels whose centre is exactly on an edge
  }
}

TEST(image_scenery_has_the_same_bits_in_all_builds) {
  for (std::uint64_t seed = 21; seed <= 26; ++seed) {
    View view = random_view(seed, 150, 139);
    view.lights = {{{1, 2, 3}, {1, 0.5f, 0.2f}, 3}, {{-2, 1, 0}, {0.2f, 0.5f, 1}, 2}};
    Solid stone;
    stone.mesh = keep(ball_mesh(3));
    view.objects.push_back(stone);
    if (seed % 2 == 0) {
      Dice dice(seed);
      for (Solid& solid : view.objects) solid.finish = {dice.between(0, 1), dice.between(0, 1)};
      for (const std::size_t number : {2, 4, 7}) view.objects[number].glass = dice.between(1.2f, 2);
      view.sky = {image::Sky::Kind::gradient, {0.8f, 0.7f, 0.6f}, {0.1f, 0.3f, 0.8f}, {0.2f, 0.1f, 0}, 0};
    }
    const Scenery first = rendered(view, *usable_cast_lanes().front());
    for (const auto* lanes : usable_cast_lanes()) {
      const Scenery other = rendered(view, *lanes);
      bool same = true;
      for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
          const int tile = tile_at(view, x, y);
          same &= first.occupied(tile) == other.occupied(tile);
          if (!first.occupied(tile) || !same) continue;
          same &= *first.depth(x, y) == *other.depth(x, y);
          same &= std::equal(first.light(x, y), first.light(x, y) + 3, other.light(x, y));
        }
      }
      CHECK(same);
    }
  }
}

TEST(image_scenery_does_not_depend_on_the_order_of_tiles) {
  const View view = random_view(31);
  const Scenery forwards = rendered(view);
  Scenery backwards;
  backwards.prepare(view);
  for (int tile = 11; tile >= 0; --tile) backwards.render(tile);
  const auto one = [&](int x, int y, std::size_t c) { return shown(forwards, view, x, y, c); };
  const auto other = [&](int x, int y, std::size_t c) { return shown(backwards, view, x, y, c); };
  CHECK(difference(view, one, other) == 0);
}

// Of two pictures by one camera with a common middle, the wider one shows more on both sides.
TEST(image_edges_on_the_border_of_a_picture_are_those_of_a_wider_one) {
  constexpr int kMore = 20;  // at each side
  int smooth = 0, apart = 0;
  for (std::uint64_t seed = 41; seed <= 80; ++seed) {
    const View view = random_view(seed, 100, 150), wider = random_view(seed, 100 + 2 * kMore, 150);
    const Scenery scenery = rendered(view), more = rendered(wider);
    View jagged = view;
    jagged.smooth = false;
    const Scenery steps = rendered(jagged);
    for (int y = 0; y < 150; ++y) {
      for (const int x : {0, 99}) {
        const double here = shown(scenery, view, x, y, 0);
        smooth += std::fabs(here - shown(steps, view, x, y, 0)) > 0.02;
        apart += std::fabs(here - shown(more, wider, x + kMore, y, 0)) > 0.02;
      }
    }
  }
  CHECK(smooth > 100);
  CHECK(apart <= 1);  // a sample may lie exactly on an edge
}

TEST(image_edges_are_smooth_unless_asked_otherwise) {
  View view = small_view(200, 150);
  view.objects = {sphere_at_origin(1)};
  view.objects[0].color = {0, 0, 0};
  view.background = {1, 1, 1};
  const auto shades = [&] {
    const Scenery scenery = rendered(view);
    int partly = 0;
    for (int y = 0; y < 150; ++y) {
      for (int x = 0; x < 200; ++x) {
        const double light = shown(scenery, view, x, y, 0);
        partly += light > 0.35 && light < 0.95;
      }
    }
    return partly;
  };
  CHECK(shades() > 50);
  view.smooth = false;
  CHECK(shades() == 0);
}

}  // namespace motes::test_image_cast
