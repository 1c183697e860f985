// Meshes as closed surfaces: which have an inside, and how far away the surface is.
#include <algorithm>
#include <cmath>
#include <string>

#include "meshes/bvh.h"
#include "meshes/distance_field.h"
#include "meshes/nearest.h"
#include "support/check.h"
#include "support/isas.h"
#include "support/made_meshes.h"

namespace motes::test_mesh_distance {
using meshes::DistanceField;
using meshes::Mesh;
using meshes::Surface;

namespace {

const std::vector<Mesh>& closed_meshes() {
  // The last one is hollow: a box with a box-shaped bubble in it.
  static const std::vector<Mesh> all = {test::globe(12, 17), test::torus(20, 9), test::tetrahedron(),
                                        test::block(-1, 2),
                                        test::together(test::block(-1, 1), test::block(-0.4, 0.5, true))};
  return all;
}

DistanceField grid_of(const Mesh& mesh, int resolution, int threads = 1) {
  threads::Pool pool(threads, threads == 1 ? SIZE_MAX : 100);
  return meshes::distance_grid(meshes::weld(mesh), resolution, pool);
}

// Calls use(place, distance) for each node.
template <class Use>
void each_node(const DistanceField& grid, const Use& use) {
  for (std::int32_t z = 0; z < grid.nodes[2]; ++z) {
    for (std::int32_t y = 0; y < grid.nodes[1]; ++y) {
      for (std::int32_t x = 0; x < grid.nodes[0]; ++x)
        use(grid.place(x, y, z), double{grid.distance[grid.at(x, y, z)]});
    }
  }
}

std::string opening_of(const Mesh& mesh) { return meshes::opening(meshes::weld(mesh)); }

}  // namespace

TEST(mesh_seams_and_poles_that_a_formula_repeats_are_one) {
  const Surface surface = meshes::weld(test::globe(12, 17));
  CHECK(surface.vertices.size() == 2 + 11 * 17);
  CHECK(surface.triangles.size() == 2 * 17 + 2 * 10 * 17);
  for (const Mesh& mesh : closed_meshes()) CHECK(opening_of(mesh).empty());
}

TEST(mesh_a_surface_without_an_inside_says_what_is_wrong) {
  Mesh open = test::block(0, 1);
  open.triangles.resize(open.triangles.size() - 3);
  CHECK(opening_of(open) == "3 open edges, the first from (1, 0, 0) to (1, 0, 1)");
  Mesh turned = test::block(0, 1);
  std::swap(turned.triangles[0], turned.triangles[1]);
  CHECK(opening_of(turned).starts_with("3 edges between triangles that face opposite sides, the first from (0, 0, 0)"));
  Mesh crowded = test::together(test::block(0, 1), test::block(0, 1));
  CHECK(opening_of(crowded).starts_with("18 edges of more than two triangles"));
  // A piece of paper is closed, but holds nothing.
  CHECK(opening_of({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 1}}) == "a volume of 0");
  CHECK(opening_of({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 1}}) == "no triangle with an area");
}

TEST(mesh_volumes_are_those_of_the_bodies) {
  CHECK_NEAR(meshes::volume(meshes::weld(test::block(-1, 2))), 27, 1e-9);
  CHECK_NEAR(meshes::volume(meshes::weld(test::block(-1, 2, true))), -27, 1e-9);
  CHECK_NEAR(meshes::volume(meshes::weld(test::tetrahedron())), 1.0 / 3, 1e-9);
  CHECK_NEAR(meshes::volume(meshes::weld(closed_meshes().back())), 8 - 0.729, 1e-6);
}

TEST(mesh_nearest_places_have_the_distance_and_the_side_that_trying_all_triangles_gives) {
  test::Dice dice(3);
  for (const Mesh& mesh : closed_meshes()) {
    const Surface surface = meshes::weld(mesh);
    const meshes::SignedDistance nearest(surface, 1);
    for (int i = 0; i < 2000; ++i) {
      const double x = dice.between(-2, 2), y = dice.between(-2, 2), z = dice.between(-2, 2);
      CHECK_NEAR(nearest.distance({x, y, z}, 1e9), test::distance_by_trying(mesh, x, y, z), 1e-6);
    }
    CHECK(nearest.distance({9, 9, 9}, 0.5) == 0.5);
  }
}

namespace {

// Compares the side of points near a place with the result of trying all triangles.
void check_sides(const Mesh& mesh, float x, float y, float z) {
  test::Dice dice(4);
  const Surface surface = meshes::weld(mesh);
  const meshes::SignedDistance nearest(surface, 1);
  for (int i = 0; i < 500; ++i) {
    const double px = x + dice.between(-0.2f, 0.2f), py = y + dice.between(-0.2f, 0.2f),
                 pz = z + dice.between(-0.2f, 0.2f);
    const double wanted = test::distance_by_trying(mesh, px, py, pz);
    if (std::fabs(wanted) > 1e-6) CHECK((nearest.distance({px, py, pz}, 1e9) < 0) == (wanted < 0));
  }
}

// Returns a needle, whose tips are sharp. One of the sides that meet at the first tip is cut into many triangles.
Mesh needle(int cuts) {
  Mesh mesh = test::tetrahedron();  // sides 012, 023, 031 and 132
  for (int i = 1; i < cuts; ++i) {
    const float part = static_cast<float>(i) / static_cast<float>(cuts);
    for (std::size_t c = 0; c < 3; ++c) {
      mesh.vertices.push_back(mesh.vertices[3 + c] + (mesh.vertices[6 + c] - mesh.vertices[3 + c]) * part);
    }
  }
  mesh.triangles = {0, 2, 3, 0, 3, 1};
  std::uint32_t last = 1;
  for (int i = 1; i <= cuts; ++i) {
    const auto next = i == cuts ? 2u : static_cast<std::uint32_t>(3 + i);
    mesh.triangles.insert(mesh.triangles.end(), {0, last, next, 3, next, last});
    last = next;
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) mesh.vertices[i] *= 20;
  return mesh;
}

}  // namespace

// If the nearest place is an edge or a corner, a single triangle may give the wrong side, and so may the mean, if one
// side has more triangles than others.
TEST(mesh_sides_are_right_near_sharp_corners) {
  for (const int cuts : {1, 40}) {
    const Mesh mesh = needle(cuts);
    CHECK(opening_of(mesh).empty());
    for (std::size_t v = 0; v < 12; v += 3)
      check_sides(mesh, mesh.vertices[v], mesh.vertices[v + 1], mesh.vertices[v + 2]);
  }
}

// A vertex on an edge, joined to it by a triangle without width whose normal, by rounding, faces inwards.
TEST(mesh_slivers_do_not_turn_sides_around) {
  Mesh mesh = test::block(-1, 1);
  const float beyond = 1 + 0x1p-22f;
  mesh.vertices.insert(mesh.vertices.end(), {beyond, 0, beyond - 2});
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    if (mesh.triangles[i] == 0 && mesh.triangles[i + 1] == 3 && mesh.triangles[i + 2] == 1) mesh.triangles[i + 2] = 8;
  }
  mesh.triangles.insert(mesh.triangles.end(), {0, 8, 1, 3, 1, 8});
  CHECK(opening_of(mesh).empty());
  check_sides(mesh, 1, 0.3f, -1);
  check_sides(mesh, 1, -0.4f, -1);
}

TEST(mesh_grids_are_exact_near_the_surface_and_not_far_off_elsewhere) {
  for (const Mesh& mesh : closed_meshes()) {
    const DistanceField grid = grid_of(mesh, 20);
    each_node(grid, [&](const Vector& p, double found) {
      const double wanted = test::distance_by_trying(mesh, p[0], p[1], p[2]);
      if (std::fabs(wanted) < 2.9 * double{grid.cell}) {
        CHECK_NEAR(found, wanted, 1e-6);
      } else {
        CHECK((found < 0) == (wanted < 0));
        CHECK(std::fabs(found) <= 1.25 * std::fabs(wanted) && std::fabs(found) >= 0.8 * std::fabs(wanted));
      }
    });
  }
}

TEST(mesh_a_surface_that_faces_inwards_has_the_same_grid) {
  const DistanceField outwards = grid_of(test::block(-1, 2), 20), inwards = grid_of(test::block(-1, 2, true), 20);
  CHECK(outwards.nodes == inwards.nodes);
  double apart = 0;
  for (std::size_t i = 0; i < outwards.distance.size(); ++i) {
    apart = std::max(apart, std::fabs(double{outwards.distance[i]} - double{inwards.distance[i]}));
  }
  CHECK(apart < 1e-6);
}

TEST(mesh_grids_have_the_same_bits_for_any_number_of_threads) {
  const DistanceField alone = grid_of(test::torus(40, 20), 40);
  for (const int threads : {2, 5}) {
    const DistanceField shared = grid_of(test::torus(40, 20), 40, threads);
    CHECK(shared.distance == alone.distance);
  }
}

TEST(mesh_inner_cells_are_those_with_a_corner_inside) {
  const Mesh ball = test::globe(10, 15);
  const DistanceField grid = grid_of(ball, 12);
  const std::vector<std::uint32_t> cells = meshes::inner_cells(grid);
  CHECK(std::is_sorted(cells.begin(), cells.end()));
  std::size_t found = 0;
  for (std::int32_t z = 0; z + 1 < grid.nodes[2]; ++z) {
    for (std::int32_t y = 0; y + 1 < grid.nodes[1]; ++y) {
      for (std::int32_t x = 0; x + 1 < grid.nodes[0]; ++x) {
        double least = 1;
        for (int c = 0; c < 8; ++c) {
          const Vector p = grid.place(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
          least = std::min(least, test::distance_by_trying(ball, p[0], p[1], p[2]));
        }
        const auto number = static_cast<std::uint32_t>(grid.at(x, y, z));
        const bool there = std::binary_search(cells.begin(), cells.end(), number);
        if (std::fabs(least) > 1e-6) CHECK(there == (least < 0));
        found += there ? 1 : 0;
      }
    }
  }
  CHECK(found == cells.size());
}

}  // namespace motes::test_mesh_distance
