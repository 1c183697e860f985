// Meshes as shapes: what they contain, their samples, and paths that meet them, in all builds.
#include <cmath>
#include <vector>

#include "base/fields.h"
#include "meshes/form.h"
#include "particles/streams.h"
#include "program/program.h"
#include "support/check.h"
#include "support/isas.h"
#include "support/made_meshes.h"

namespace motes::test_mesh_shapes {
using meshes::Mesh;
using shapes::Kind;
using shapes::Shape;

namespace {

constexpr int kSolid = 14, kResolution = 15;

Shape mesh_shape(const Mesh& mesh, bool solid = false, int resolution = 32) {
  float number[shapes::kNumbers] = {};
  number[3] = number[10] = 1;
  number[kSolid] = solid ? 1 : 0;
  number[kResolution] = static_cast<float>(resolution);
  const Shape shape = shapes::mesh_shape(meshes::keep(mesh), number);
  shapes::check_region(shape);
  return shape;
}

Shape turned(Shape shape) {
  const float numbers[] = {0.5f, 0.25f, -1, 0.5f, 0.5f, -0.5f, 0.5f};
  for (int i = 0; i < 7; ++i) shape.number[i] = shape.number[7 + i] = numbers[i];
  return shape;
}

Shape moving(Shape shape) {
  shape = turned(shape);
  shape.number[7] -= 0.3f;
  shape.number[10] = 1;
  shape.number[11] = shape.number[12] = shape.number[13] = 0;
  return shape;
}

struct Points {
  std::vector<float> plane[3];
  explicit Points(std::size_t n) {
    for (auto& p : plane) p.resize(n + particles::kPadding);
  }
  double at(std::size_t i, int c) const { return double{plane[c][i]}; }
};

Points drawn(const actions::Kernels& kernels, const Shape& shape, std::size_t n, std::size_t first = 0) {
  std::vector<std::uint64_t> ids(n + particles::kPadding);
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = first + i;
  Points points(n);
  float* into[3] = {points.plane[0].data(), points.plane[1].data(), points.plane[2].data()};
  const actions::distributions::InShape d{shape};
  particles::DrawKeys draws;
  kernels.draw(d, nullptr, {0, 0, particles::user_sample, particles::system_key(5, 0), 0, &draws},
               particles::IdList(ids), n, into, 3);
  return points;
}

// Returns a box of points around the shape.
Points cloud(std::size_t n, float reach) {
  test::Dice dice(8);
  Points points(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (auto& plane : points.plane) plane[i] = dice.between(-reach, reach);
  }
  return points;
}

std::vector<std::uint8_t> inside(const actions::Kernels& kernels, const Shape& shape, const Points& points) {
  const std::size_t n = points.plane[0].size() - particles::kPadding;
  const float* position[3] = {points.plane[0].data(), points.plane[1].data(), points.plane[2].data()};
  std::vector<std::uint8_t> found(n);
  kernels.contains(shape, position, n, found.data());
  return found;
}

// Returns chi square per degree of freedom of samples over cells that hold equal parts: how unevenly they are spread.
double unevenness(const std::vector<std::size_t>& cells) {
  double sum = 0, total = 0;
  for (const std::size_t n : cells) total += static_cast<double>(n);
  const double wanted = total / static_cast<double>(cells.size());
  for (const std::size_t n : cells)
    sum += (static_cast<double>(n) - wanted) * (static_cast<double>(n) - wanted) / wanted;
  return sum / static_cast<double>(cells.size() - 1);
}

std::size_t cell(double part, std::size_t count) {
  return std::min(static_cast<std::size_t>(part * static_cast<double>(count)), count - 1);
}

// The particles after a step of `bounce` in one build.
struct Bounced {
  Points position, velocity;
};
Bounced bounced(const actions::Kernels& kernels, const Shape& shape, float dt) {
  constexpr std::size_t kCount = 128;
  Bounced made{cloud(kCount, 2), cloud(kCount, 2)};
  for (std::size_t i = 0; i < kCount; ++i) {
    for (int c = 0; c < 3; ++c) made.velocity.plane[c][i] = -9 * made.position.plane[(c + 1) % 3][i];
  }
  const particles::Schema schema;
  std::vector<float> other(kCount + particles::kPadding);
  std::vector<float*> planes(static_cast<std::size_t>(schema.components()), other.data());
  for (int c = 0; c < 3; ++c) {
    planes[static_cast<std::size_t>(schema[particles::position].first_component + c)] = made.position.plane[c].data();
    planes[static_cast<std::size_t>(schema[particles::velocity].first_component + c)] = made.velocity.plane[c].data();
  }
  const particles::IdList ids(std::vector<std::uint64_t>(kCount + particles::kPadding));
  std::vector<std::uint32_t> dead(kCount / 32 + 2);
  const double numbers[] = {0.6, 0.1, 0, 1};
  const actions::Parameters p{numbers, &shape};
  kernels.action[static_cast<std::size_t>(actions::Kind::bounce)](p, {kCount, planes.data(), ids, dead.data()},
                                                                  {dt, 0, 1, {1, 2}, 0, nullptr, 0.25f, 0.75f});
  return made;
}

bool same(const Points& a, const Points& b) {
  return a.plane[0] == b.plane[0] && a.plane[1] == b.plane[1] && a.plane[2] == b.plane[2];
}

}  // namespace

TEST(mesh_shapes_hold_what_is_inside_up_to_the_cells_error) {
  const Mesh mesh = test::torus(30, 15);
  const Shape shape = mesh_shape(mesh);
  const Points points = cloud(3000, 1.5f);
  const auto found = inside(actions::kernels(), shape, points);
  int agree = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double distance = test::distance_by_trying(mesh, points.at(i, 0), points.at(i, 1), points.at(i, 2));
    if (std::fabs(distance) < 0.5 * double{shape.form->cell}) continue;
    CHECK((found[i] != 0) == (distance < 0));
    ++agree;
  }
  CHECK(agree > 2500);
}

TEST(mesh_shapes_have_the_same_bits_in_all_builds) {
  const Mesh mesh = test::torus(30, 15);
  const Points points = cloud(500, 1.5f);
  for (const Shape& shape :
       {mesh_shape(mesh), mesh_shape(mesh, true), turned(mesh_shape(mesh, true)), moving(mesh_shape(mesh))}) {
    const auto builds = test::builds();
    const auto held = inside(builds[0].kernels, shape, points);
    const Points samples = drawn(builds[0].kernels, shape, 512);
    const Bounced steps = bounced(builds[0].kernels, shape, 0.3f);
    for (const auto& build : builds) {
      CHECK(inside(build.kernels, shape, points) == held);
      CHECK(same(drawn(build.kernels, shape, 512), samples));
      const Bounced other = bounced(build.kernels, shape, 0.3f);
      CHECK(same(other.position, steps.position) && same(other.velocity, steps.velocity));
      // A lane's result does not depend on its neighbours.
      const Points later = drawn(build.kernels, shape, 100, 7);
      for (std::size_t i = 0; i < 100; ++i) CHECK(later.at(i, 0) == samples.at(7 + i, 0));
    }
  }
}

TEST(mesh_samples_of_the_surface_are_uniform_by_area) {
  // A box with sides of very different triangles.
  Mesh mesh = test::block(0, 1);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) mesh.vertices[i] *= 3;
  const Points points = drawn(actions::kernels(), mesh_shape(mesh), 60000);
  std::vector<std::size_t> strips(12);
  for (std::size_t i = 0; i < 60000; ++i) {
    const double x = points.at(i, 0), y = points.at(i, 1), z = points.at(i, 2);
    const bool end = x == 0 || x == 3;
    CHECK(end || y == 0 || y == 1 || z == 0 || z == 1);
    if (end) continue;
    const std::size_t side = y == 0 ? 0 : y == 1 ? 1 : z == 0 ? 2 : 3;
    ++strips[3 * side + cell(x / 3, 3)];
  }
  CHECK(unevenness(strips) < 3);
  double on_sides = 0;
  for (const std::size_t n : strips) on_sides += static_cast<double>(n);
  CHECK_NEAR(on_sides / 60000, 12.0 / 14, 0.007);
  CHECK_NEAR(shapes::measure(mesh_shape(mesh)), 14, 1e-9);
}

TEST(mesh_samples_of_the_inside_are_uniform_by_volume) {
  const Shape shape = mesh_shape(test::torus(120, 60), true, 48);
  const std::size_t n = 60000;
  const Points points = drawn(actions::kernels(), shape, n);
  std::vector<std::size_t> turns(24), tubes(8);
  for (std::size_t i = 0; i < n; ++i) {
    const double x = points.at(i, 0), y = points.at(i, 1), z = points.at(i, 2), r = std::hypot(x, z);
    ++turns[cell(std::atan2(z, x) / 6.283185307 + 0.5, 24)];
    // In tubes around the ring the volume grows with the square of the distance (Pappus), whatever the angle.
    ++tubes[cell(((r - 1) * (r - 1) + y * y) / (0.4 * 0.4), 8)];
  }
  CHECK(unevenness(turns) < 2);
  tubes.pop_back();  // where the triangles cut the corners
  CHECK(unevenness(tubes) < 3.5);
  const auto held = inside(actions::kernels(), shape, points);
  for (const std::uint8_t one : held) CHECK(one != 0);
  CHECK_NEAR(shapes::measure(shape), 2 * 9.8696044 * 0.16, 0.02);
}

TEST(mesh_shapes_survive_as_bytes_within_unions_too) {
  const Shape one = turned(mesh_shape(test::torus(30, 15), true));
  Shape ball;
  ball.kind = Kind::sphere;
  ball.number[3] = 1;
  for (const Shape& shape : {one, shapes::unite({ball, one})}) {
    base::Bytes bytes;
    base::write_fields(shape, bytes);
    CHECK(bytes.size() < 400);  // the mesh is named by its key
    Shape read;
    base::Reader in(bytes.view());
    base::read_fields(in, read);
    CHECK(read == shape && shapes::measure(read) == shapes::measure(shape));
    CHECK(shapes::meshes_of(read) == std::vector<std::uint64_t>{one.mesh});
    const Points points = cloud(100, 2);
    CHECK(inside(actions::kernels(), read, points) == inside(actions::kernels(), shape, points));
  }
  CHECK(!(one == turned(mesh_shape(test::torus(30, 16), true))));
}

TEST(a_union_that_is_read_shares_samples_out_as_the_one_that_was_written) {
  // A process that reads the shape has not yet built the inside of its mesh.
  float number[shapes::kNumbers] = {};
  number[3] = number[10] = number[kSolid] = 1;
  number[kResolution] = 9;  // no other test has this form
  const Shape solid = shapes::mesh_shape(meshes::keep(test::globe(8, 12)), number);
  Shape ball;
  ball.kind = Kind::sphere;
  ball.number[3] = 1;
  Shape read = shapes::unite({ball, solid});
  shapes::set_parts(read, shapes::parts_of(read));
  CHECK(solid.form->distance == nullptr);
  shapes::check(solid);
  CHECK(solid.form->distance != nullptr);
  const Shape written = shapes::unite({ball, solid});
  CHECK(read == written && shapes::measure(read) == shapes::measure(written));
  for (int i = 0; i < 2; ++i) CHECK(read.part[i].upto == written.part[i].upto);
  CHECK(written.part[0].upto > 0.5f && written.part[0].upto < 0.6f);  // the mesh is a little smaller than the ball
}

TEST(mesh_shapes_that_make_no_sense_are_refused) {
  const Shape good = mesh_shape(test::block(0, 1));
  const auto refused = [&](int number, float value) {
    Shape wrong = good;
    wrong.number[number] = value;
    try {
      shapes::check(wrong);
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  CHECK(refused(kResolution, 7) && refused(kResolution, 513) && refused(kResolution, 20.5f));
  CHECK(refused(3, 0.9f) && refused(10, 2) && refused(0, INFINITY) && refused(kSolid, 0.5f));
  Shape unknown = good;
  unknown.form = nullptr;
  CHECK_THROWS(shapes::check(unknown), std::invalid_argument);
  Shape swings = good;
  swings.number[7] = 1;
  CHECK_THROWS(shapes::check(shapes::unite({swings, good})), std::invalid_argument);
  shapes::check(shapes::unite({good, good}));
  float number[shapes::kNumbers] = {};
  number[3] = number[10] = 1;
  number[kResolution] = 16;
  Mesh open = test::block(0, 1);
  open.triangles.resize(30);
  const Shape bowl = shapes::mesh_shape(meshes::keep(open), number);
  shapes::check(bowl);  // points may be drawn from it
  CHECK_THROWS(shapes::check_region(bowl), std::invalid_argument);
  CHECK_THROWS(shapes::check_region(shapes::unite({good, bowl})), std::invalid_argument);
}

}  // namespace motes::test_mesh_shapes
