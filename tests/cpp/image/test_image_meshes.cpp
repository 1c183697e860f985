// Meshes as external objects: what rays see of them, their tree, and what is refused.
#include "image/test_image_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "image/camera.h"
#include "image/checks.h"
#include "image/raster/splat_lanes.h"
#include "image/raycast/scenery.h"
#include "image/test_image_scene.h"
#include "meshes/bvh.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::image_test {

meshes::Mesh ball_mesh(int times) {
  using Triangle = std::array<std::uint32_t, 3>;
  std::vector<std::array<double, 3>> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<Triangle> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                  {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (; times > 0; --times) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, added] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (!added) return found->second;
      std::array<double, 3> p{};
      for (std::size_t i = 0; i < 3; ++i) p[i] = points[a][i] + points[b][i];
      const double size = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
      for (double& x : p) x /= size;
      points.push_back(p);
      return found->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const Triangle& t : {Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) finer.push_back(t);
    }
    triangles = std::move(finer);
  }
  meshes::Mesh mesh;
  for (const auto& p : points) {
    mesh.vertices.insert(mesh.vertices.end(),
                         {static_cast<float>(p[0]), static_cast<float>(p[1] + 1), static_cast<float>(p[2])});
  }
  for (const Triangle& t : triangles) mesh.triangles.insert(mesh.triangles.end(), t.begin(), t.end());
  return mesh;
}

}  // namespace motes::image_test

namespace motes::test_image_meshes {
using namespace image_test;
using test::Dice;

namespace {

Solid mesh_solid(const meshes::Mesh& mesh) {
  Solid solid;
  solid.mesh = meshes::keep(mesh);
  solid.color = {0.8f, 0.5f, 0.3f};
  return solid;
}

Solid ground() {
  Solid solid;
  solid.shape.kind = shapes::Kind::plane;
  solid.shape.number[4] = 1;
  solid.color = {0.6f, 0.6f, 0.6f};
  return solid;
}

Solid ball() {
  Solid solid = mesh_solid(ball_mesh(0));
  solid.mesh = 0;
  solid.shape.kind = shapes::Kind::sphere;
  solid.shape.number[1] = 1;
  solid.shape.number[3] = 1;
  return solid;
}

View view_of(std::vector<Solid> objects) {
  View view = small_view(320, 200);
  view.camera.position = {2, 3, 5};
  view.camera.look_at = {0, 1, 0};
  view.background = {0.1f, 0.1f, 0.2f};
  view.objects = std::move(objects);
  return view;
}

// Returns the light of every pixel, in units of 64 sums; pixels that are not occupied have that of the background.
std::vector<int> light_of(const View& view) {
  Scenery scenery;
  scenery.prepare(view);
  scenery.render_all();
  std::vector<int> light;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const bool occupied = scenery.occupied(y / 64 * ((view.width + 63) / 64) + x / 64);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t sum = occupied ? scenery.light(x, y)[c] : scenery.background()[c];
        light.push_back(static_cast<int>(sum / 64));
      }
    }
  }
  return light;
}

}  // namespace

TEST(image_a_mesh_looks_like_the_shape_that_it_approximates) {
  const std::vector<int> shape = light_of(view_of({ground(), ball()}));
  double before = 1e9;
  for (const int times : {2, 4, 6}) {
    const std::vector<int> mesh = light_of(view_of({ground(), mesh_solid(ball_mesh(times))}));
    double sum = 0;
    for (std::size_t i = 0; i < mesh.size(); ++i) sum += std::abs(mesh[i] - shape[i]);
    const double mean = sum / static_cast<double>(mesh.size()) / 16192 * 255;  // in 1/255 of full light
    CHECK(mean < 0.5 * before);
    before = mean;
  }
  CHECK(before < 0.1);
}

// From inside a closed mesh the background is not visible anywhere, including edges of triangles, vertices, and the
// four samples of pixels on creases.
TEST(image_meshes_are_watertight) {
  Dice dice(7);
  for (const int times : {0, 3, 5}) {
    View view = view_of({mesh_solid(ball_mesh(times))});
    view.objects[0].color = {0, 0, 0};
    view.background = {4, 4, 4};
    for (int turn = 0; turn < 4; ++turn) {
      // The first view goes exactly at a vertex along an axis.
      view.camera.position = {0, 1, 0};
      if (turn > 0)
        view.camera.position = {dice.between(-0.2f, 0.2f), dice.between(0.8f, 1.2f), dice.between(-0.2f, 0.2f)};
      view.camera.look_at = view.camera.position;
      view.camera.look_at[2] -= 1;
      view.camera.near = 1e-3;
      view.camera.fov_deg = 120;
      const std::vector<int> light = light_of(view);
      CHECK(*std::max_element(light.begin(), light.end()) < 8000);  // fog adds little
    }
  }
}

TEST(image_a_mesh_throws_shadows_on_itself_and_on_others) {
  // A roof over a table, in one mesh, over the ground.
  const meshes::Mesh roof{{-1, 2, -1, 1, 2, -1, 1, 2, 1, -1, 2, 1, -2, 0.5f, -2, 2, 0.5f, -2, 2, 0.5f, 2, -2, 0.5f, 2},
                          {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7}};
  View view = view_of({ground(), mesh_solid(roof)});
  view.sun = {0, 1, 0};
  view.camera.position = {0, 1.5, 6};
  view.camera.look_at = {0, 0.5, 0};
  const std::vector<int> light = light_of(view);
  const auto at = [&](const Vector& point) {
    const Lens l = lens(view);
    double x = 0, y = 0, z = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double offset = point[i] - l.eye[i];
      x += l.right[i] * offset, y += l.up[i] * offset, z += l.forward[i] * offset;
    }
    const int column = static_cast<int>(160 + l.focal_px * x / z), row = static_cast<int>(100 - l.focal_px * y / z);
    return light[static_cast<std::size_t>(3 * (row * 320 + column))];
  };
  CHECK(at({-1.7, 0.5, 0.5}) > 2 * at({0.1, 0.5, 0.5}));  // on the table: beside the roof's shadow and in it
  CHECK(at({2.4, 0, 2.2}) > 2 * at({0.5, 0, 1.9}) || at({0, 0, 2.6}) > 2 * at({0, 0, 1.7}));
  CHECK(at({0, 0, 2.6}) > 3000);
}

TEST(image_the_tree_of_a_mesh_holds_each_triangle_once) {
  meshes::Mesh mesh = ball_mesh(4);
  const std::size_t count = mesh.triangles.size() / 3;
  mesh.triangles.insert(mesh.triangles.end(), {0, 0, 1, 2, 2, 2});  // without an area
  const meshes::Bvh tree = build_bvh(mesh);
  CHECK(tree.triangles.size() == count);
  std::vector<int> seen(count);
  std::vector<std::pair<std::uint32_t, int>> stack{{0, 0}};
  int deepest = 0;
  while (!stack.empty()) {
    const auto [at, depth] = stack.back();
    stack.pop_back();
    const meshes::BvhNode& node = tree.nodes[at];
    deepest = std::max(deepest, depth);
    const auto inside = [&](const float* low, const float* high) {
      for (int i = 0; i < 3; ++i) CHECK(low[i] >= node.low[i] && high[i] <= node.high[i]);
    };
    for (std::uint32_t i = 0; i < node.count; ++i) {
      ++seen[node.first + i];
      for (const float* corner : tree.triangles[node.first + i].corner) inside(corner, corner);
    }
    for (std::uint32_t child = node.first; node.count == 0 && child < node.first + 2; ++child) {
      inside(tree.nodes[child].low, tree.nodes[child].high);
      stack.emplace_back(child, depth + 1);
    }
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
  CHECK(deepest < 24);
}

// All triangles at the same place, and triangles whose sizes grow by powers of two: no split by place helps.
TEST(image_trees_of_strange_meshes_stay_shallow_enough) {
  meshes::Mesh same, growing;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    same.vertices.insert(same.vertices.end(), {0, 0, 0, 1, 0, 0, 0, 1, 0});
    const float size = std::ldexp(1.0f, static_cast<int>(i % 90) - 45);
    growing.vertices.insert(growing.vertices.end(), {size, 0, 0, 2 * size, 0, 0, size, size, size});
    for (meshes::Mesh* mesh : {&same, &growing})
      mesh->triangles.insert(mesh->triangles.end(), {3 * i, 3 * i + 1, 3 * i + 2});
  }
  for (const meshes::Mesh& mesh : {same, growing}) {
    const std::vector<int> light = light_of(view_of({mesh_solid(mesh)}));
    CHECK(light.size() == 3 * 320 * 200);
  }
  const meshes::Mesh flat{{0, 0, 0, 1, 1, 1, 2, 2, 2}, {0, 1, 2}};
  CHECK(meshes::build_bvh(flat).triangles.empty());
  CHECK(light_of(view_of({mesh_solid(flat)})) == light_of(view_of({})));
}

TEST(image_an_unknown_mesh_is_refused) {
  View view = view_of({ball()});
  view.objects[0].mesh = 4711;
  CHECK_THROWS(image::check(view), std::invalid_argument);
  Scenery scenery;
  CHECK_THROWS(scenery.prepare(view), std::invalid_argument);
}

}  // namespace motes::test_image_meshes
