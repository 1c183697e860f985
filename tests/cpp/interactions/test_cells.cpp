// The order (cell, id) compared with a plain sort, for particles in any order in memory, with any of them as ghosts, on
// any number of threads.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

#include "support/check.h"
#include "support/crowds.h"

namespace motes::test_cells {
using interactions::Cells;
using test::Dice;
using test::Flock;

namespace {

constexpr std::int32_t kFarthest = 1 << 20;

struct Scene {
  const char* name;
  double edge;
  Flock flock;
};

struct Place {
  std::array<std::int32_t, 3> cell;
  std::uint64_t id;
  auto operator<=>(const Place&) const = default;
};

std::int32_t cell_of(float x, double edge) {
  if (std::isnan(x)) return -kFarthest;
  const double q = std::floor(static_cast<double>(x) * (1 / edge));
  return static_cast<std::int32_t>(std::clamp<double>(q, -kFarthest, kFarthest));
}

Place place_of(const Scene& scene, std::size_t i) {
  Place place;
  for (std::size_t c = 0; c < 3; ++c) place.cell[c] = cell_of(scene.flock.column[c][i], scene.edge);
  place.id = scene.flock.ids[i];
  return place;
}

// Returns the order by its definition.
std::vector<Place> sorted(const Scene& scene) {
  std::vector<Place> places;
  for (std::size_t i = 0; i < scene.flock.size(); ++i) places.push_back(place_of(scene, i));
  std::sort(places.begin(), places.end());
  return places;
}

std::uint32_t most_in_a_cell(const std::vector<Place>& places) {
  std::uint32_t most = 0;
  std::uint32_t here = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    here = k > 0 && places[k].cell == places[k - 1].cell ? here + 1 : 1;
    most = std::max(most, here);
  }
  return most;
}

// Checks that rows cover the order; each has one x and y, and its table leads to the first particle of each z.
void check_rows(const Cells& cells, const std::vector<Place>& places) {
  const interactions::CellsView view = cells.view(0);
  CHECK(view.row_count + 1 == cells.rows().size());
  CHECK(cells.rows().front().first == 0 && cells.rows().back().first == places.size());
  for (std::size_t r = 0; r < view.row_count; ++r) {
    const interactions::Row& row = view.rows[r];
    const std::uint32_t end = view.rows[r + 1].first;
    CHECK(row.first < end);
    const auto& before = view.rows[r + 1];
    CHECK(std::tie(row.x, row.y) < std::tie(before.x, before.y));
    CHECK(row.z_low == places[row.first].cell[2] && row.z_high == places[end - 1].cell[2]);
    for (std::uint32_t k = row.first; k < end; ++k) {
      const std::array<std::int32_t, 3> found{row.x, row.y, view.z[k]};
      CHECK(found == places[k].cell);
    }
    if (row.table < 0) continue;
    std::uint32_t k = row.first;
    for (std::int32_t z = row.z_low; z <= row.z_high + 1; ++z) {
      while (k < end && places[k].cell[2] < z) ++k;
      CHECK(view.table[row.table + (z - row.z_low)] == k);
    }
  }
}

void check_order(const Scene& scene, threads::Pool& pool, Dice& dice) {
  std::vector<std::size_t> shuffled(scene.flock.size());
  for (std::size_t i = 0; i < shuffled.size(); ++i) shuffled[i] = i;
  test::shuffle(shuffled, dice);
  const Scene mixed{scene.name, scene.edge, test::taken(scene.flock, shuffled, dice.below(scene.flock.size() + 1))};
  Cells cells;
  const particles::IdList others = scene.flock.own_ids(), own = mixed.flock.own_ids();
  cells.sort(scene.flock.crowd(others), 1.0, pool);  // working memory of another meeting
  const interactions::Crowd crowd = mixed.flock.crowd(own);
  cells.sort(crowd, scene.edge, pool);
  const std::vector<Place> places = sorted(scene);
  CHECK(cells.size() == places.size());
  std::vector<Place> found;
  for (const std::uint32_t i : cells.order()) found.push_back(place_of(mixed, i));
  if (found != places) check::fail(__FILE__, __LINE__, scene.name);
  CHECK(cells.most_in_a_cell() == most_in_a_cell(places));
  check_rows(cells, places);
  std::vector<float> arranged(cells.size());
  cells.arrange(crowd, mixed.flock.plane(interactions::velocity_x), arranged.data(), pool);
  for (std::size_t k = 0; k < arranged.size(); ++k)
    CHECK(arranged[k] == mixed.flock.column[interactions::velocity_x][cells.order()[k]]);
}

Flock scaled(std::size_t count, float half, std::uint64_t seed) { return test::random_flock(count, half, seed); }

std::vector<Scene> scenes() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<Scene> all{
      {"a box", 0.1, scaled(3000, 1, 1)},
      {"one cell", 3, scaled(3000, 1, 2)},  // negative and positive: eight
      {"one each", 0.01, scaled(3000, 1, 3)},
      {"sparse", 0.02, scaled(2000, 5000, 4)},  // rows without a table
      {"far apart", 1e-3, scaled(2000, 3000, 5)},  // beyond the outermost cells
      {"without an edge", static_cast<double>(kInfinity), scaled(500, 1, 6)},
      {"one", 1, scaled(1, 1, 7)},
      {"none", 1, scaled(0, 1, 8)},
  };
  Scene lost{"lost", 0.1, scaled(600, 1, 9)};
  Dice dice(10);
  for (int k = 0; k < 60; ++k) {
    const float odd[] = {std::nanf(""), kInfinity, -kInfinity, 3e38f, -0.0f, 1e5f};
    lost.flock.column[dice.below(3)][dice.below(600)] = odd[dice.below(6)];
  }
  all.push_back(lost);
  Scene crowded{"crowded", 0.1, scaled(1500, 1, 11)};  // one giant cell among others
  for (std::size_t i = 0; i < 1000; ++i) {
    for (std::size_t c = 0; c < 3; ++c) crowded.flock.column[c][i] = 0.05f;
  }
  all.push_back(crowded);
  Scene edges{"on the edges of cells", 0.125, scaled(2000, 1, 12)};
  for (std::size_t c = 0; c < 3; ++c) {
    for (float& x : edges.flock.column[c]) x = std::round(x * 8) / 8;
  }
  all.push_back(edges);
  return all;
}

}  // namespace

TEST(cells_put_particles_into_the_order_of_cell_and_id) {
  Dice dice(1);
  threads::Pool two(2, 64);
  threads::Pool three(3, 7);
  for (const Scene& scene : scenes()) {
    for (threads::Pool* pool : {&threads::alone(), &two, &three}) {
      for (int round = 0; round < 3; ++round) check_order(scene, *pool, dice);
    }
  }
}

// In float32 the quotient would round up to the next cell here and there.
TEST(cells_are_numbered_in_double_precision) {
  Scene scene{"far from the origin", 0.3 * (1 + 1e-6), test::random_flock(4000, 1, 2)};
  for (float& x : scene.flock.column[0]) x = 20000 + 100 * x;
  std::size_t differ = 0;
  for (const float x : scene.flock.column[0]) {
    const float in_float = std::floor(x * (1 / static_cast<float>(scene.edge)));
    differ += in_float == static_cast<float>(cell_of(x, scene.edge)) ? 0 : 1;
  }
  CHECK(differ > 10);
  Dice dice(3);
  check_order(scene, threads::alone(), dice);
}

TEST(uniform_columns_stand_for_all_own_particles) {
  Flock flock = test::random_flock(400, 1, 3);
  for (float& z : flock.column[2]) z = 0.75f;
  Cells by_planes;
  const particles::IdList own_ids = flock.own_ids();
  by_planes.sort(flock.crowd(own_ids), 0.2, threads::alone());
  interactions::Crowd crowd = flock.crowd(own_ids);
  crowd.at[2] = {nullptr, nullptr, 0.75f};
  Cells cells;
  cells.sort(crowd, 0.2, threads::alone());
  CHECK(cells.order() == by_planes.order());
  std::vector<float> z(cells.size());
  cells.arrange(crowd, crowd.at[2], z.data(), threads::alone());
  CHECK(std::count(z.begin(), z.end(), 0.75f) == 400);
}

}  // namespace motes::test_cells
