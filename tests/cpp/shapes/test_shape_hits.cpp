// Where paths meet the surfaces of triangles, cylinders, cones and unions: compared with analytic values, from both
// sides, at any speed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "support/check.h"
#include "support/functions_builds.h"

namespace motes::test_shape_hits {
namespace {

using shapes::Kind;
using shapes::Shape;
using Vector = std::array<double, 3>;

struct Met {
  double part;  // below 0: no hit
  Vector normal;
};

Met meet(const Shape& shape, const Vector& from, const Vector& path) {
  std::vector<float> plane[6], out[4];
  for (int c = 0; c < 3; ++c) {
    plane[c].assign(16, static_cast<float>(from[c]));
    plane[c + 3].assign(16, static_cast<float>(path[c]));
  }
  for (auto& o : out) o.resize(16);
  const float* p[3] = {plane[0].data(), plane[1].data(), plane[2].data()};
  const float* d[3] = {plane[3].data(), plane[4].data(), plane[5].data()};
  float* normal[3] = {out[1].data(), out[2].data(), out[3].data()};
  test::function_builds().back()->hit(shape, p, d, 16, out[0].data(), normal);
  return {out[0][0], {out[1][0], out[2][0], out[3][0]}};
}

void check_met(const Shape& shape, const Vector& from, const Vector& path, double part, const Vector& normal) {
  const Met met = meet(shape, from, path);
  CHECK_NEAR(met.part, part, 1e-6);
  for (int c = 0; c < 3; ++c) CHECK_NEAR(met.normal[c], normal[c], 1e-6);
}

void check_missed(const Shape& shape, const Vector& from, const Vector& path) {
  CHECK(meet(shape, from, path).part < 0);
}

const Shape kTriangle{Kind::triangle, {0, 0, 0, 2, 0, 0, 0, 0, 4}};
const Shape kCylinder{Kind::cylinder, {0, 0, 0, 0, 4, 0, 1, 0}};  // along y
const Shape kPipe{Kind::cylinder, {0, 0, 0, 0, 4, 0, 2, 1}};
const Shape kTube{Kind::cylinder, {0, 0, 0, 0, 4, 0, 1, 1}};
const Shape kCone{Kind::cone, {0, 4, 0, 0, 0, 0, 4, 0}};  // apex above, sides at 45 degrees
const Shape kHat{Kind::cone, {0, 4, 0, 0, 0, 0, 4, 4}};
const double kDiagonal = std::sqrt(0.5);

}  // namespace

TEST(hit_a_triangle) {
  check_met(kTriangle, {0.5, 1, 0.5}, {0, -4, 0}, 0.25, {0, 1, 0});
  check_met(kTriangle, {0.5, -1, 0.5}, {0, 4, 0}, 0.25, {0, -1, 0});
  check_met(kTriangle, {-0.5, 1, 0.5}, {1, -1, 0}, 1, {0, 1, 0});
  check_met(kTriangle, {0.5, 1, 0.5}, {0, -1e6, 0}, 1e-6, {0, 1, 0});
  check_missed(kTriangle, {1.5, 1, 1.5}, {0, -4, 0});  // beyond the long edge
  check_missed(kTriangle, {0.5, 1, 0.5}, {0, -0.9, 0});
  check_missed(kTriangle, {0.5, 1, 0.5}, {1, 0, 0});
}

TEST(hit_a_cylinder_from_outside) {
  check_met(kCylinder, {3, 2, 0}, {-4, 0, 0}, 0.5, {1, 0, 0});
  check_met(kCylinder, {3, 1, 0}, {-4, 1, 0}, 0.5, {1, 0, 0});
  check_met(kCylinder, {0.5, 6, 0}, {0, -4, 0}, 0.5, {0, 1, 0});
  check_met(kCylinder, {0.5, -1, 0}, {0, 1e5, 0}, 1e-5, {0, -1, 0});
  check_met(kCylinder, {3, 2, 0}, {-4e6, 0, 0}, 5e-7, {1, 0, 0});
  check_met(kCylinder, {0.6, 2, 5}, {0, 0, -8.4}, 0.5, {0.6, 0, 0.8});
  check_met(kCylinder, {2, 6, 0}, {-4, -4, 0}, 0.5, {0, 1, 0});  // over the top of the rim, onto the middle of the cap
  check_missed(kCylinder, {3, 5, 0}, {-8, 0, 0});
  check_missed(kCylinder, {3, 2, 1.1}, {-8, 0, 0});
  check_missed(kCylinder, {3, 2, 0}, {4, 0, 0});
  check_missed(kCylinder, {3, 2, 0}, {0, 0, 0});
  check_missed(kCylinder, {2, 6, 0}, {0, -8, 0});  // along the axis, beside it
}

TEST(hit_a_cylinder_from_inside) {
  check_met(kCylinder, {0, 2, 0}, {2, 0, 0}, 0.5, {-1, 0, 0});
  check_met(kCylinder, {0.5, 2, 0}, {0, 4, 0}, 0.5, {0, -1, 0});
  check_met(kCylinder, {0.5, 2, 0}, {0, -4e5, 0}, 5e-6, {0, 1, 0});
  check_met(kCylinder, {0, 2, 0}, {4, 4, 0}, 0.25, {-1, 0, 0});
  check_missed(kCylinder, {0, 2, 0}, {0.5, 1, 0});
  check_missed(kCylinder, {0, 2, 0}, {0, 0, 0});
}

TEST(hit_a_pipe) {
  check_met(kPipe, {4, 2, 0}, {-4, 0, 0}, 0.5, {1, 0, 0});  // its outside
  check_met(kPipe, {0, 2, 0}, {2, 0, 0}, 0.5, {-1, 0, 0});  // the bore's wall
  check_met(kPipe, {1.5, 2, 0}, {-1, 0, 0}, 0.5, {1, 0, 0});  // out of the material into the bore
  check_met(kPipe, {1.5, 2, 0}, {1, 0, 0}, 0.5, {-1, 0, 0});  // out of the material
  check_met(kPipe, {1.5, 6, 0}, {0, -4, 0}, 0.5, {0, 1, 0});  // the ring at the end
  check_met(kPipe, {-1, 6, 0}, {4, -8, 0}, 0.5, {-1, 0, 0});  // through the open end onto the bore's wall
  check_missed(kPipe, {0.5, 6, 0}, {0, -8, 0});  // right through
}

TEST(hit_an_open_tube) {
  check_met(kTube, {3, 2, 0}, {-4, 0, 0}, 0.5, {1, 0, 0});
  check_met(kTube, {0, 2, 0}, {2, 0, 0}, 0.5, {-1, 0, 0});
  check_met(kTube, {-1, 6, 0}, {4, -8, 0}, 0.5, {-1, 0, 0});
  check_missed(kTube, {0.5, 6, 0}, {0, -8, 0});
  check_missed(kTube, {0.5, 2, 0}, {0, 8, 0});
}

TEST(hit_a_cone) {
  check_met(kCone, {4, 2, 0}, {-4, 0, 0}, 0.5, {kDiagonal, kDiagonal, 0});
  check_met(kCone, {0, 2, 0}, {4, 0, 0}, 0.5, {-kDiagonal, -kDiagonal, 0});
  check_met(kCone, {1, -1, 0}, {0, 2, 0}, 0.5, {0, -1, 0});  // the base
  check_met(kCone, {1, 1, 0}, {0, -2, 0}, 0.5, {0, 1, 0});  // the base, from inside
  check_met(kCone, {1, 5, 0}, {0, -4, 0}, 0.5, {kDiagonal, kDiagonal, 0});  // steeper than the side
  check_met(kCone, {1, 1, 0}, {0, 4, 0}, 0.5, {-kDiagonal, -kDiagonal, 0});  // the same from inside
  check_met(kCone, {4, 4, 0}, {-4, -4, 0}, 0.5, {kDiagonal, kDiagonal, 0});  // along the other side's slope
  check_met(kCone, {1, 9, 0}, {0, -1.2e6, 0}, 5e-6, {kDiagonal, kDiagonal, 0});
  check_missed(kCone, {1, 5, 0}, {1, 0, 0});  // in the mirror image above the apex
  check_missed(kCone, {2, 6, 0}, {-4, 0, 0});  // through the mirror image
  check_missed(kCone, {5, 0.5, 0}, {-2, 2, 0});  // along a generator, outside
  check_missed(kCone, {1, 1, 0}, {0.5, 0.5, 0});
}

TEST(hit_a_hat) {
  check_met(kHat, {1, -1, 0}, {0, 8, 0}, 0.5, {-kDiagonal, -kDiagonal, 0});  // through the open base
  check_met(kHat, {1, 5, 0}, {0, -4, 0}, 0.5, {kDiagonal, kDiagonal, 0});
  check_missed(kHat, {1, 1, 0}, {0, -4, 0});
}

TEST(hit_the_nearest_part_of_a_union) {
  const Shape ball{Kind::sphere, {0, 0, 0, 1, 0}}, box{Kind::box, {2, -1, -1, 4, 1, 1}};
  const Shape both = shapes::unite({box, ball});
  check_met(both, {-3, 0, 0}, {4, 0, 0}, 0.5, {-1, 0, 0});
  check_met(both, {6, 0, 0}, {-8, 0, 0}, 0.25, {1, 0, 0});
  check_met(both, {3, 0, 0}, {2, 0, 0}, 0.5, {-1, 0, 0});
  check_missed(both, {-3, 2, 0}, {9, 0, 0});
}

namespace {

// Bounces particles of any speed around and in the shape in random steps; none may change sides.
void check_no_leak(const Shape& shape, float dt) {
  constexpr std::size_t kCount = 4096;
  const test::Build build = test::builds().back();
  test::Dice dice(31);
  std::vector<float> plane[6];
  const particles::IdList ids(std::vector<std::uint64_t>(kCount + 16));
  std::vector<std::uint32_t> dead(kCount / 32 + 2);
  for (auto& p : plane) p.resize(kCount + 16);
  for (std::size_t i = 0; i < kCount; ++i) {
    for (int c = 0; c < 3; ++c) plane[c][i] = dice.between(-5, 5);
    for (int c = 3; c < 6; ++c) plane[c][i] = dice.between(-3, 3);
  }
  std::vector<float> age(kCount + 16);
  float* components[32] = {plane[0].data(), plane[1].data(), plane[2].data(),
                           plane[3].data(), plane[4].data(), plane[5].data()};
  components[20] = age.data();
  const float* position[3] = {components[0], components[1], components[2]};
  const double restitution[4] = {1, 0, 0, 1}, no_turning[1] = {0};
  const actions::Block block{kCount, components, ids, dead.data()};
  const actions::Step step{dt, 0, 0, {}};
  std::vector<std::uint8_t> before(kCount), after(kCount);
  build.kernels.contains(shape, position, kCount, before.data());
  std::size_t leaked = 0, inside = 0;
  for (int frame = 0; frame < 400; ++frame) {
    for (const auto& [kind, numbers] :
         {std::pair{actions::Kind::bounce, restitution}, std::pair{actions::Kind::move, no_turning}}) {
      actions::Parameters parameters{};
      parameters.number = numbers;
      parameters.shape = &shape;
      build.kernels.action[static_cast<std::size_t>(kind)](parameters, block, step);
    }
    for (std::size_t i = 0; i < kCount; ++i) {  // bring particles back
      for (int c = 0; c < 3; ++c) {
        if (std::fabs(plane[c][i]) > 5) plane[c + 3][i] = std::copysign(plane[c + 3][i], -plane[c][i]);
      }
    }
  }
  build.kernels.contains(shape, position, kCount, after.data());
  for (std::size_t i = 0; i < kCount; ++i) {
    leaked += before[i] != after[i] ? 1u : 0u;
    inside += before[i];
  }
  CHECK(leaked == 0);
  CHECK(inside > 100);
}

// Returns which of these positions a shape contains: they are one float32 apart and straddle its surface.
std::vector<std::uint8_t> held(const Shape& shape, int along, const std::vector<float>& at) {
  std::vector<float> plane[3];
  for (std::vector<float>& values : plane) values.assign(at.size() + 16, 0.0f);
  std::copy(at.begin(), at.end(), plane[along].begin());
  const float* const position[3] = {plane[0].data(), plane[1].data(), plane[2].data()};
  std::vector<std::uint8_t> inside(at.size());
  test::builds().back().kernels.contains(shape, position, at.size(), inside.data());
  return inside;
}

}  // namespace

TEST(shapes_hold_places_by_more_than_the_rounding_of_their_size) {
  const std::vector<float> near{-1e-6f, -1e-9f, -1e-20f, 1e-20f, 1e-9f, 1e-6f};
  const std::vector<std::uint8_t> below{1, 1, 1, 0, 0, 0}, by_double{1, 1, 1, 1, 0, 0};
  CHECK(held({Kind::plane, {0, 0, 0, 0.1f, 1, 0.05f}}, 1, near) == below);
  CHECK(held({Kind::plane, {500, -50, 0, 0.1f, 1, 0}}, 1, {-1e-3f, 1e-3f}) == std::vector<std::uint8_t>({1, 0}));
  // Below 50 m times 2^-53, the rounding of double precision decides.
  CHECK(held({Kind::sphere, {0, -50, 0, 50, 0}}, 1, near) == by_double);
  CHECK(held({Kind::cylinder, {-3, -50, 0, 3, -50, 0, 50, 0}}, 1, near) == by_double);
}

TEST(no_particle_slips_through_a_surface) {
  check_no_leak({Kind::cylinder, {-1, -2, 0, 1, 2, 1, 2, 0}}, 0.01f);
  check_no_leak({Kind::cylinder, {-1, -2, 0, 1, 2, 1, 3, 1.5f}}, 0.01f);
  check_no_leak({Kind::cone, {0, 3, 0, 0, -2, 1, 4, 0}}, 0.01f);
  check_no_leak({Kind::cone, {0, 3, 0, 0, -2, 1, 4, 2}}, 0.01f);
  check_no_leak({Kind::sphere, {0, 0, 0, 2, 0}}, 0.01f);
  check_no_leak({Kind::box, {-2, -2, -2, 2, 2, 2}}, 0.01f);
  check_no_leak(shapes::unite({kCylinder, {Kind::sphere, {-3, -3, 0, 2, 0}}}), 0.01f);
  check_no_leak({Kind::cylinder, {-1, -2, 0, 1, 2, 1, 2, 0}}, 0.5f);  // several hits per step
  check_no_leak({Kind::cone, {0, 3, 0, 0, -2, 1, 4, 0}}, 0.5f);
}

// A path that the first, cheap test calls clear of a box is clear by the exact one, too, whatever is rounded.
TEST(paths_clear_of_a_box_meet_none_of_its_faces) {
  const float least = std::numeric_limits<float>::denorm_min();
  const std::vector<std::array<float, 6>> boxes = {
      {-10, 0, -10, 10, 10, 10},     {99990, -3, 1e5f, 100010, 5, 100000.5f}, {0, 0, 0, 0, 0, 0},
      {-1, 2, -1, 1, 2, 1},          {1000, 0, 0, 1000.001f, 1e-3f, 1e-3f},   {-1e30f, -1e30f, 0, 1e30f, 1e30f, 1},
      {0, 0, 0, least, least, least}};
  std::mt19937 dice(1);
  const auto pick = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(dice); };
  const auto sized = [&](double low, double high) { return std::copysign(std::pow(10, pick(low, high)), pick(-1, 1)); };
  constexpr std::size_t kPaths = 16384;
  for (const auto& box : boxes) {
    Shape shape{Kind::box, {}};
    std::copy(box.begin(), box.end(), shape.number);
    std::vector<std::vector<float>> x(3, std::vector<float>(kPaths)), v = x;
    for (std::size_t i = 0; i < kPaths; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double face = box[dice() % 2 * 3 + c], size = std::abs(face) + 1e-6;
        x[c][i] = static_cast<float>(dice() % 4 == 0 ? face : face + sized(-8, 1) * size);
        v[c][i] = static_cast<float>(dice() % 8 == 0 ? 0 : sized(-7, 2) * size);
        // As many end at a face.
        if (dice() % 4 == 0) v[c][i] = (static_cast<float>(face) - x[c][i]) * 24;
      }
    }
    const float* p[3] = {x[0].data(), x[1].data(), x[2].data()};
    const float* d[3] = {v[0].data(), v[1].data(), v[2].data()};
    std::vector<float> exact(kPaths), first(kPaths);
    for (const auto* build : test::function_builds()) {
      build->nears(shape, p, d, 1.0f / 24, kPaths, exact.data(), first.data());
      CHECK(std::count(exact.begin(), exact.end(), 1.0f) > 100);
      for (std::size_t i = 0; i < kPaths; ++i) CHECK(first[i] >= exact[i]);
    }
  }
}

// Far from the box and deep inside it, the first test is enough.
TEST(paths_far_from_the_faces_of_a_box_are_clear) {
  const Shape box{Kind::box, {-10, 0, -10, 10, 10, 10}};
  const std::vector<float> x(16, 0), high(16, 12), low(16, 5), v(16, 24);  // one metre per step
  const float *above[3] = {x.data(), high.data(), x.data()}, *within[3] = {x.data(), low.data(), x.data()};
  const float* d[3] = {v.data(), v.data(), v.data()};
  std::vector<float> exact(16), first(16);
  for (const auto* build : test::function_builds()) {
    for (const auto* p : {above, within}) {
      build->nears(box, p, d, 1.0f / 24, 16, exact.data(), first.data());
      CHECK(std::count(first.begin(), first.end(), 0.0f) == 16);
    }
  }
}

}  // namespace motes::test_shape_hits
