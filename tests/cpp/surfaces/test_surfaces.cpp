// Surfaces of particles: closed for any densities; sums that do not depend on order or on who adds.
#include <array>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "support/check.h"
#include "surfaces/cube_cases.h"
#include "surfaces/field.h"
#include "surfaces/skin.h"

namespace motes::test_surfaces {
using namespace surfaces;

namespace {

struct Places {
  std::vector<float> x, y, z;
  std::array<const float*, 3> planes() const { return {x.data(), y.data(), z.data()}; }
};

Places places(std::size_t count, float width, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> within(-width, width);
  Places made;
  for (std::size_t i = 0; i < count; ++i) {
    made.x.push_back(within(random));
    made.y.push_back(within(random));
    made.z.push_back(within(random));
  }
  return made;
}

Field field_of(const Places& all, const Measure& measure, std::size_t first, std::size_t last) {
  Field field(measure);
  field.add(all.planes(), first, last);
  return field;
}

bool is_closed(const Skin& skin) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t i = 0; i < skin.triangles.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!edges.insert({skin.triangles[i + k], skin.triangles[i + (k + 1) % 3]}).second) return false;
    }
  }
  for (const auto& [from, to] : edges) {
    if (!edges.contains({to, from})) return false;
  }
  return !edges.empty();
}

// Adds a block of sums that random() gives, and empty ones before it.
template <class Random>
void add_block(Field& field, const Random& random) {
  base::Bytes bytes;
  bytes.put(std::uint64_t{8});
  for (int b = 0; b < 8; ++b) {
    bytes.put(key_of(b & 1, b >> 1 & 1, b >> 2));
    for (std::size_t i = 0; i < kNodes; ++i) bytes.put(b == 7 ? random() : std::uint32_t{0});
  }
  base::Reader in(bytes.view());
  field.add(in);
}

bool same(const Skin& a, const Skin& b) { return a.vertices == b.vertices && a.triangles == b.triangles; }

}  // namespace

// Every edge of the cell that the surface crosses is in a polygon, every other one in none.
TEST(cube_cases_use_the_edges_that_are_crossed) {
  for (unsigned inside = 0; inside < 256; ++inside) {
    std::set<int> used;
    for (const std::uint8_t corner : cube_cases()[inside].triangles) {
      if (corner < kCentre) used.insert(corner);
    }
    for (int edge = 0; edge < kEdges; ++edge) {
      const auto [a, b] = corners_of_edge(edge);
      const bool crossed = ((inside >> a ^ inside >> b) & 1u) != 0;
      CHECK(used.contains(edge) == crossed);
    }
  }
}

TEST(surfaces_are_closed_for_any_densities) {
  std::mt19937 random(5);
  for (int i = 0; i < 30; ++i) {
    Field field({0.5, 0.5});
    add_block(field, [&] { return static_cast<std::uint32_t>(random()) >> 11 | 1u; });
    CHECK(is_closed(skin_of(field, threads::alone())));
  }
  for (const double cell : {0.3, 0.5, 1.0}) {
    const Places all = places(3000, 4, 7);
    CHECK(is_closed(skin_of(field_of(all, {cell, 0.5}, 0, 3000), threads::alone())));
  }
}

// The outermost nodes that a heap of particles reaches are inside, and begin a block.
TEST(surfaces_of_heaps_are_closed_at_borders_of_blocks) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<float> planes[3] = {std::vector<float>(60000), std::vector<float>(60000), std::vector<float>(60000)};
    planes[axis].assign(60000, 1.2f);
    Field field({0.25, 0.5});
    field.add({planes[0].data(), planes[1].data(), planes[2].data()}, 0, 60000);
    CHECK(is_closed(skin_of(field, threads::alone())));
  }
}

TEST(surfaces_keep_full_sums) {
  Field field({0.5, 0.5});
  add_block(field, [] { return kMostSum - 1; });
  add_block(field, [] { return std::uint32_t{9}; });
  CHECK((*field.find(key_of(1, 1, 1)))[0] == kMostSum);
}

TEST(surfaces_do_not_depend_on_who_adds_or_on_threads) {
  const Places all = places(2000, 3, 8);
  const Measure measure{0.25, 0.3};
  const Skin whole = skin_of(field_of(all, measure, 0, 2000), threads::alone());
  Field parts = field_of(all, measure, 700, 2000);
  base::Bytes bytes;
  field_of(all, measure, 0, 700).write(bytes);
  base::Reader in(bytes.view());
  parts.add(in);
  CHECK(in.done());
  threads::Pool three(3);
  CHECK(same(whole, skin_of(parts, three)));
  Field together = field_of(all, measure, 0, 1);
  together.add(field_of(all, measure, 1, 2000));
  CHECK(same(whole, skin_of(together, threads::alone())));
}

// A sum that is full stays so, in any order.
TEST(surfaces_of_heaps_at_one_place_are_those_of_one_particle) {
  Places heap;
  heap.x.assign(20000, 0.1f);
  heap.y.assign(20000, 0.2f);
  heap.z.assign(20000, 0.3f);
  Field field = field_of(heap, {0.25, 0.5}, 0, 20000);
  std::uint32_t most = 0;
  for (const BlockKey key : field.keys())
    for (const std::uint32_t sum : *field.find(key)) most = std::max(most, sum);
  CHECK(most == kMostSum);
  field.add(field_of(heap, {0.25, 0.5}, 0, 20000));
  const Skin skin = skin_of(field, threads::alone());
  CHECK(is_closed(skin));
  float farthest = 0;
  for (std::size_t i = 0; i < skin.vertices.size(); i += 3) farthest = std::max(farthest, skin.vertices[i]);
  CHECK(farthest < 0.1f + 0.5f * static_cast<float>(kReach) + 0.25f);
}

TEST(surfaces_leave_out_particles_at_no_place) {
  Places all = places(5, 1, 3);
  all.y[1] = std::numeric_limits<float>::quiet_NaN();
  all.z[3] = -std::numeric_limits<float>::infinity();
  Places placed;
  for (const std::size_t i : {0u, 2u, 4u}) {
    placed.x.push_back(all.x[i]);
    placed.y.push_back(all.y[i]);
    placed.z.push_back(all.z[i]);
  }
  const Measure measure{0.2, 0.3};
  CHECK(same(skin_of(field_of(all, measure, 0, 5), threads::alone()),
             skin_of(field_of(placed, measure, 0, 3), threads::alone())));
}

TEST(surfaces_refuse_what_does_not_fit) {
  CHECK_THROWS(check({0.01, 1}), std::invalid_argument);
  CHECK_THROWS(check({2.1, 1}), std::invalid_argument);
  CHECK_THROWS(check({1, 0}), std::invalid_argument);
  Places far = places(1, 1, 9);
  far.x[0] = 1e9f;
  CHECK(field_of(far, {0.1, 0.1}, 0, 1).too_large());
  far.x[0] = 1e5f;
  CHECK(!field_of(far, {0.1, 0.1}, 0, 1).too_large());
  const auto place = place_of(key_of(-3, 5, 7));
  CHECK(place[0] == -3 && place[1] == 5 && place[2] == 7);
}

}  // namespace motes::test_surfaces
