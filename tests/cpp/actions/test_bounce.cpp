// Bounces: the exact point of the hit, from both sides, at any speed, and no sinking.
#include <cmath>
#include <vector>

#include "program/program.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_bounce {
using particles::Store;
using shapes::Kind;
using shapes::Shape;

namespace {

const particles::Schema kSchema;

struct Vector {
  double x, y, z;
};

Shape shape(Kind kind, std::initializer_list<float> numbers) {
  Shape s;
  s.kind = kind;
  std::size_t i = 0;
  for (const float number : numbers) s.number[i++] = number;
  return s;
}

struct Particle {
  Vector position, velocity;
};

double length(Vector v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

// A store that bounces its particles, step by step.
struct World {
  Store store{kSchema};
  program::Program program;
  double dt;
  std::uint64_t frame = 0;

  World(const std::vector<Particle>& particles, const Shape& s, double step_s, double restitution = 1,
        double friction = 0, double gravity = 0, double cutoff = 0, bool exact_hit = true)
      : program({actions::make(actions::numbers::gravity<>{.acceleration = {0, gravity, 0}}),
                 actions::make(actions::numbers::bounce<>{.restitution = restitution,
                                                          .friction = friction,
                                                          .min_tangential_speed = cutoff,
                                                          .exact_hit = exact_hit ? 1.0 : 0.0},
                               {s}),
                 actions::make(actions::numbers::move<>{})}),
        dt(step_s) {
    store.grow(particles.size());
    for (std::size_t i = 0; i < particles.size(); ++i) {
      store.set_id(i, i);
      const Vector x = particles[i].position, v = particles[i].velocity;
      const double xs[3] = {x.x, x.y, x.z}, vs[3] = {v.x, v.y, v.z};
      for (int c = 0; c < 3; ++c) {
        store.writable_plane(particles::position, c)[i] = static_cast<float>(xs[c]);
        store.writable_plane(particles::velocity, c)[i] = static_cast<float>(vs[c]);
      }
    }
  }
  void step() {
    program::ListResult outcome;
    program.run(store, 0, 0, {frame++, 1, dt, 0}, {1, 2}, {}, outcome);
  }
  Vector get(int attribute, std::size_t i) const {
    return {store.plane(attribute, 0)[i], store.plane(attribute, 1)[i], store.plane(attribute, 2)[i]};
  }
  Vector position(std::size_t i = 0) const { return get(particles::position, i); }
  Vector velocity(std::size_t i = 0) const { return get(particles::velocity, i); }
};

void near(Vector a, Vector b, double tolerance, int line) {
  const double away = length({a.x - b.x, a.y - b.y, a.z - b.z});
  if (!(away <= tolerance)) {
    check::fail("test_bounce", line,
                "(" + check::text(a.x) + ", " + check::text(a.y) + ", " + check::text(a.z) + ") is not (" +
                    check::text(b.x) + ", " + check::text(b.y) + ", " + check::text(b.z) + ")");
  }
}
#define NEAR(a, b) near(a, b, 2e-5, __LINE__)

// Checks the position and velocity after one step with one hit.
void one_step(const Shape& s, Particle before, Vector position, Vector velocity, int line, double restitution = 1,
              double friction = 0, double dt = 0.2) {
  World world({before}, s, dt, restitution, friction);
  world.step();
  near(world.position(), position, 2e-5, line);
  near(world.velocity(), velocity, 2e-5, line);
}
#define ONE_STEP(s, before, ...) one_step(s, before, __VA_ARGS__)

const Shape kFloor = shape(Kind::plane, {0, 0, 0, 0, 2, 0});
const Shape kBox = shape(Kind::box, {-1, -1, -1, 1, 1, 1});
const Shape kBall = shape(Kind::sphere, {0, 0, 0, 1, 0});
const Shape kTable = shape(Kind::rectangle, {-1, 0, -1, 2, 0, 0, 0, 0, 2});
const Shape kRing = shape(Kind::disc, {0, 0, 0, 0, 3, 0, 1, 0.25f});

std::vector<Particle> swarm(std::size_t count, double within, double speed) {
  test::Dice dice(21);
  std::vector<Particle> all;
  const auto any = [&](double scale) { return scale * static_cast<double>(dice.between(-1, 1)); };
  for (std::size_t i = 0; i < count; ++i) {
    all.push_back({{any(within), any(within), any(within)}, {any(speed), any(speed), any(speed)}});
  }
  return all;
}

}  // namespace

TEST(bounce_happens_at_the_true_place) {
  // Half of the step down, half of it up.
  ONE_STEP(kFloor, (Particle{{0, 1, 0}, {1, -10, 2}}), {0.2, 1, 0.4}, {1, 10, 2}, __LINE__);
  ONE_STEP(kFloor, (Particle{{0, 1, 0}, {1, -10, 2}}), {0.2, 0.5, 0.4}, {1, 5, 2}, __LINE__, 0.5);
  // Friction slows the particle from the hit on.
  ONE_STEP(kFloor, (Particle{{0, 1, 0}, {1, -10, 2}}), {0.175, 0.5, 0.35}, {0.75, 5, 1.5}, __LINE__, 0.5, 0.25);
  ONE_STEP(kFloor, (Particle{{0, 3, 0}, {1, -10, 2}}), {0.2, 1, 0.4}, {1, -10, 2}, __LINE__);
  ONE_STEP(kFloor, (Particle{{0, 1, 0}, {1, 10, 2}}), {0.2, 3, 0.4}, {1, 10, 2}, __LINE__);
}

TEST(bounce_from_both_sides_of_flat_shapes) {
  for (const Shape& s : {kTable, kRing}) {
    ONE_STEP(s, (Particle{{0.5, 1, 0}, {0, -10, 0}}), {0.5, 1, 0}, {0, 10, 0}, __LINE__);
    ONE_STEP(s, (Particle{{0.5, -1, 0}, {0, 10, 0}}), {0.5, -1, 0}, {0, -10, 0}, __LINE__);
    ONE_STEP(s, (Particle{{1.5, 1, 0}, {0, -10, 0}}), {1.5, -1, 0}, {0, -10, 0}, __LINE__);
  }
  // Through the ring's hole.
  const Particle through{{0.1, 1, 0.1}, {0, -10, 0}};
  ONE_STEP(kRing, through, {0.1, -1, 0.1}, {0, -10, 0}, __LINE__);
  World velocities_alone({through}, kRing, 0.2, 1, 0, 0, 0, false);
  velocities_alone.step();
  NEAR(velocities_alone.velocity(), through.velocity);
  ONE_STEP(kTable, (Particle{{0.1, 1, 0.1}, {0, -10, 0}}), {0.1, 1, 0.1}, {0, 10, 0}, __LINE__);
}

TEST(bounce_from_both_sides_of_solids) {
  for (const Shape& s : {kBox, kBall}) {
    ONE_STEP(s, (Particle{{3, 0, 0}, {-20, 0, 0}}), {3, 0, 0}, {20, 0, 0}, __LINE__);
    ONE_STEP(s, (Particle{{0, -3, 0}, {0, 20, 0}}), {0, -3, 0}, {0, -20, 0}, __LINE__);
    ONE_STEP(s, (Particle{{0, 0, 0}, {0, 0, 7.5}}), {0, 0, 0.5}, {0, 0, -7.5}, __LINE__);
    ONE_STEP(s, (Particle{{0.5, 0, 0}, {5, 0, 0}}), {0.5, 0, 0}, {-5, 0, 0}, __LINE__);
    ONE_STEP(s, (Particle{{3, 2, 0}, {-20, 0, 0}}), {-1, 2, 0}, {-20, 0, 0}, __LINE__);
  }
  // Off the axis of a ball: hit at height 0.6, where the normal is (0.8, 0.6, 0).
  ONE_STEP(kBall, (Particle{{1.8, 0.6, 0}, {-10, 0, 0}}), {0.8 + 0.28, 0.6 + 0.96, 0}, {2.8, 9.6, 0}, __LINE__);
  // A box is hit at the face that the path meets first.
  ONE_STEP(kBox, (Particle{{2, 0.5, 0}, {-10, 1, 0}}), {2, 0.7, 0}, {10, 1, 0}, __LINE__);
}

TEST(bounce_with_restitution_one_keeps_the_speed) {
  for (const Shape& s : {kBox, kBall, kFloor, kTable, kRing}) {
    const std::vector<Particle> particles = swarm(300, 0.9, 10);
    World world(particles, s, 0.02);
    for (int i = 0; i < 300; ++i) world.step();
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const double before = length(particles[i].velocity);
      CHECK_NEAR(length(world.velocity(i)) / before, 1, 1e-4);
    }
  }
}

TEST(bounce_lets_nothing_sink) {
  for (const double restitution : {0.0, 0.3, 0.9}) {
    std::vector<Particle> particles = swarm(200, 3, 4);
    for (Particle& particle : particles) particle.position.y = std::fabs(particle.position.y);
    World world(particles, kFloor, 1.0 / 24, restitution, 0.1, -9.8);
    double lowest = 0;
    for (int i = 0; i < 2000; ++i) {
      world.step();
      for (std::size_t p = 0; p < 200; ++p) lowest = std::fmin(lowest, world.position(p).y);
    }
    CHECK_NEAR(lowest, 0, 1e-3);
    for (std::size_t p = 0; restitution < 0.5 && p < 200; ++p) CHECK_NEAR(world.position(p).y, 0, 0.5);
  }
}

TEST(bounce_stops_the_fastest) {
  for (const double speed : {1e2, 1e4, 1e6}) {
    World table({{{0.3, 0.5, 0.2}, {0, -speed, 0}}}, kTable, 0.04);
    table.step();
    CHECK(table.position().y > 0 && table.velocity().y > 0);
    World floor({{{0.3, 0.5, 0.2}, {1, -speed, 0}}}, kFloor, 0.04);
    floor.step();
    CHECK(floor.position().y > 0);
    World ball({{{9, 0.2, 0.1}, {-speed, 0, 0}}}, kBall, 0.9 / 1e2 * 10);
    ball.step();
    CHECK(ball.position().x > 0 && ball.velocity().x > 0);
    World box({{{9, 0.2, 0.1}, {-speed, 0, 0}}}, kBox, 0.9 / 1e2 * 10);
    box.step();
    CHECK(box.position().x > 1 && box.velocity().x > 0);
  }
}

TEST(bounce_keeps_a_swarm_inside) {
  for (const Shape& s : {kBox, kBall}) {
    const std::size_t count = 2000;
    World world(swarm(count, 0.5, 3), s, 1.0 / 24, 0.95);
    for (int i = 0; i < 500; ++i) world.step();
    std::size_t outside = 0;
    for (std::size_t p = 0; p < count; ++p) {
      const Vector x = world.position(p);
      const double most = std::fmax(std::fabs(x.x), std::fmax(std::fabs(x.y), std::fabs(x.z)));
      outside += (s.kind == Kind::box ? most : length(x)) > 1.001 ? 1 : 0;
    }
    CHECK_NEAR(static_cast<double>(outside), 0, 0);
  }
}

namespace {

// Returns metres above the surface, in double precision.
using Height = double (*)(Vector);

// Checks that particles within the surface, or all outside it, still are after some steps; `rounding`: error of a
// coordinate.
void check_held(World& world, std::size_t count, Height height, double side, double rounding, int steps, int line) {
  std::size_t lost = 0;
  for (int step = 0; step < steps; ++step) world.step();
  for (std::size_t i = 0; i < count; ++i) lost += height(world.position(i)) * side < -rounding ? 1 : 0;
  if (lost != 0) check::fail("test_bounce", line, std::to_string(lost) + " of " + std::to_string(count) + " are lost");
}

std::vector<Particle> swarm_at(Vector place, std::size_t count, double within, double speed) {
  std::vector<Particle> all = swarm(count, within, speed);
  for (Particle& p : all) p.position = {p.position.x + place.x, p.position.y + place.y, p.position.z + place.z};
  return all;
}

double over_ball(Vector x) { return length({x.x, x.y - 2, x.z}) - 2; }
double over_big_ball(Vector x) { return length({x.x, x.y + 50, x.z}) - 50; }
double over_log(Vector x) { return std::hypot(x.y + 2, x.z) - 2; }
double over_glass(Vector x) { return std::fmax(std::hypot(x.x, x.z) - 1, std::fabs(x.y) - 1); }
double over_tip(Vector x) {  // apex (0, 2, 0), base (0, -2, 0), radius 2
  return std::fmax((std::hypot(x.x, x.z) - 0.5 * (2 - x.y)) / std::sqrt(1.25), -2 - x.y);
}
double over_unit_ball(Vector x) { return length(x) - 1; }
double over_unit_box(Vector x) { return std::fmax(std::fabs(x.x), std::fmax(std::fabs(x.y), std::fabs(x.z))) - 1; }
double over_ramp(Vector x) { return (0.1 * x.x + x.y + 0.05 * x.z) / std::sqrt(1.0125); }

const Shape kGlass = shape(Kind::cylinder, {0, -1, 0, 0, 1, 0, 1, 0});
const Shape kTip = shape(Kind::cone, {0, 2, 0, 0, -2, 0, 2, 0});

}  // namespace

TEST(bounce_holds_where_a_surface_passes_the_origin) {
  // At the origin coordinates are tiny, while a hit's rounding is that of the shape's size.
  struct Case {
    Shape shape;
    Vector start;
    Height height;
    double side;
  };
  const Case cases[] = {{shape(Kind::sphere, {0, 2, 0, 2, 0}), {0, 1, 0}, over_ball, -1},
                        {shape(Kind::sphere, {0, -50, 0, 50, 0}), {0, 0.5, 0}, over_big_ball, 1},
                        {shape(Kind::cylinder, {-4, -2, 0, 4, -2, 0, 2, 0}), {0, 0.5, 0}, over_log, 1},
                        {shape(Kind::disc, {0, 0, 0, 0.1f, 1, 0.05f, 90, 0}), {0, 0.5, 0}, over_ramp, 1},
                        {shape(Kind::plane, {0, 0, 0, 0.1f, 1, 0.05f}), {0, 0.5, 0}, over_ramp, 1}};
  for (const Case& c : cases) {
    for (const double restitution : {0.2, 0.5, 0.0}) {
      World world(swarm_at(c.start, 300, 0.1, 0.1), c.shape, 1.0 / 24, restitution, 0.5, -9.8);
      check_held(world, 300, c.height, c.side, 1e-6, 60, __LINE__);
    }
  }
}

TEST(bounce_off_flat_ends_at_the_slowest) {
  for (const double aside : {0.0, 1e-15, 3e-18, 1e-19, 1e-22, 1e-30, 1e-38}) {
    World glass({{{0.1, -0.99, 0.05}, {aside, -1, 0}}}, kGlass, 1.0 / 24, 0.2, 0.5);
    check_held(glass, 1, over_glass, -1, 1e-6, 1, __LINE__);
    CHECK(glass.velocity().y > 0);
  }
}

TEST(bounce_along_round_walls) {
  const std::vector<std::pair<Shape, Height>> walls = {{kGlass, over_glass}, {kTip, over_tip}, {kBall, over_unit_ball}};
  for (const auto& [s, height] : walls) {
    for (const double restitution : {0.0, 0.1}) {
      World inside(swarm_at({0, -0.5, 0}, 500, 0.3, 2), s, 1.0 / 24, restitution, 0.02, -9.8);
      check_held(inside, 500, height, -1, 1e-6, 200, __LINE__);
    }
  }
}

TEST(bounce_ends_a_step_at_the_last_hit_that_it_follows) {
  for (const double speed : {60.0, 1e3, 1e4}) {
    for (const auto& [s, height] : {std::pair{kBall, &over_unit_ball}, std::pair{kBox, &over_unit_box},
                                    std::pair{kGlass, &over_glass}, std::pair{kTip, &over_tip}}) {
      World world(swarm_at({0, -0.5, 0}, 500, 0.3, speed), s, 1.0 / 24, 1, 0);
      check_held(world, 500, height, -1, 1e-6, 10, __LINE__);
    }
  }
}

TEST(bounce_meets_what_is_small_and_far) {
  for (const Shape& s :
       {shape(Kind::sphere, {0, 0, 0, 0.001f, 0}), shape(Kind::cylinder, {-0.001f, 0, 0, 0.001f, 0, 0, 0.001f, 0})}) {
    World world({{{0, 0.0004, 300}, {0, 0, -6000}}}, s, 0.1);
    world.step();
    CHECK(world.velocity().z > 0);
    CHECK(world.position().z > 200);
  }
}

TEST(bounce_by_the_predicted_place_keeps_the_side) {
  for (const auto& [s, height] : {std::pair{kBox, &over_unit_box}, std::pair{kGlass, &over_glass},
                                  std::pair{kTip, &over_tip}, std::pair{kBall, &over_unit_ball}}) {
    World world(swarm_at({0, -0.5, 0}, 500, 0.3, 8), s, 1.0 / 24, 0.9, 0, -9.8, 0, false);
    check_held(world, 500, height, -1, 1e-6, 200, __LINE__);
  }
}

TEST(bounce_has_no_friction_at_low_tangential_speed) {
  World slow({{{0, 0.1, 0}, {0.5, -10, 0}}}, kFloor, 0.1, 1, 0.5, 0, 1);
  slow.step();
  CHECK_NEAR(slow.velocity().x, 0.5, 1e-6);
  World fast({{{0, 0.1, 0}, {2, -10, 0}}}, kFloor, 0.1, 1, 0.5, 0, 1);
  fast.step();
  CHECK_NEAR(fast.velocity().x, 1, 1e-6);
}

TEST(a_plane_along_an_axis_is_any_plane) {
  // A plane turned so little that no result changes counts as oblique: its paths are followed in double precision.
  test::Dice dice(8);
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {1.0f, -1.0f}) {
      std::vector<Particle> particles;
      for (int i = 0; i < 300; ++i) {
        const auto number = [&](float most) { return static_cast<double>(dice.between(-most, most)); };
        particles.push_back({{number(1), number(1), number(1)}, {number(30), number(30), number(30)}});
      }
      Shape straight = shape(Kind::plane, {0.25f, 0.25f, 0.25f, 0, 0, 0}), tilted = straight;
      for (std::size_t c = 0; c < 3; ++c) tilted.number[3 + c] = 1e-30f;
      straight.number[static_cast<std::size_t>(3 + axis)] = tilted.number[static_cast<std::size_t>(3 + axis)] = side;
      World one(particles, straight, 0.04, 0.7, 0.2, -9.8, 20), other(particles, tilted, 0.04, 0.7, 0.2, -9.8, 20);
      for (int step = 0; step < 5; ++step) {
        one.step();
        other.step();
      }
      for (const int attribute : {particles::position, particles::velocity}) {
        for (int c = 0; c < 3; ++c) {
          const float *a = one.store.plane(attribute, c), *b = other.store.plane(attribute, c);
          for (std::size_t i = 0; i < particles.size(); ++i) CHECK_NEAR(a[i], b[i], 1e-4);
        }
      }
    }
  }
}

TEST(no_plane_turns_a_particle_of_infinite_velocity) {
  for (int axis = 0; axis < 3; ++axis) {
    Shape plane = shape(Kind::plane, {0, 0, 0, 0, 0, 0});
    plane.number[static_cast<std::size_t>(3 + axis)] = 1;
    double down[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    down[axis] = -9;
    World world({{{0.1, 0.1, 0.1}, {down[0], down[1], down[2]}}}, plane, 0.04);
    world.step();
    for (int c = 0; c < 3; ++c) {
      CHECK(world.store.plane(particles::velocity, c)[0] == static_cast<float>(down[c]));
      CHECK(world.store.plane(particles::position, c)[0] == 0.1f);
    }
  }
}

}  // namespace motes::test_bounce
