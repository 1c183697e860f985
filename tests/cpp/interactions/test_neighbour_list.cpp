// Neighbour lists: which pairs they contain, how long they hold, and what pairs remember from list to list.
#include "interactions/neighbour_list.h"

#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "support/check.h"
#include "support/crowds.h"

namespace motes::test_neighbour_list {
namespace {

using interactions::NeighbourList;
using test::Flock;

// A flock and its neighbour list.
struct Listed {
  Flock flock;
  particles::Schema schema;
  particles::Store store{schema};
  NeighbourList list;
  std::vector<float> diameters;

  explicit Listed(Flock given) : flock(std::move(given)) { store.grow(flock.own); }

  float reach() const {
    float most = 0;
    for (const float r : flock.column[interactions::radius]) most = std::max(most, 2 * r);
    return most;
  }

  interactions::Column sizes() {
    diameters = flock.column[interactions::radius];
    for (float& diameter : diameters) diameter *= 2;
    diameters.resize(diameters.size() + particles::kPadding);
    return {diameters.data(), nullptr, 0};
  }

  // Returns whether the list was kept.
  bool meet(std::uint32_t now) {
    const particles::IdList ids = flock.own_ids();
    const interactions::Crowd crowd = flock.crowd(ids);
    std::vector<float> columns[4];
    const auto arrange = [&] {
      const int read[4] = {interactions::at_x, interactions::at_y, interactions::at_z, interactions::radius};
      for (std::size_t c = 0; c < 4; ++c) {
        columns[c].resize(flock.size() + 2 * particles::kPadding);
        list.cells().arrange(crowd, flock.plane(static_cast<std::size_t>(read[c])), columns[c].data(),
                             threads::alone());
      }
      return interactions::PlacedSpheres{{columns[0].data(), columns[1].data(), columns[2].data()}, columns[3].data()};
    };
    interactions::Crowd own = crowd;
    own.ghosts = 0;
    const interactions::Radii radii{0, sizes(), {nullptr, nullptr, 1}, false};
    const bool kept = list.holds(own, radii, now, threads::alone());
    if (!kept) {
      list.sort(crowd, reach(), interactions::skin_of(list.wear(), reach(), false), threads::alone());
      list.build(crowd, arrange(), store, 0, now, threads::alone());
    }
    list.view(now);
    return kept;
  }

  // Return pairs by ids: those that are listed, and those that touch.
  std::set<std::pair<std::uint64_t, std::uint64_t>> listed() {
    std::set<std::pair<std::uint64_t, std::uint64_t>> found;
    const interactions::PairsView view = list.view(1);
    for (std::size_t k = 0; k < list.ids().size(); ++k) {
      std::uint64_t last = 0;
      for (std::uint32_t e = view.begin[k]; e < view.begin[k + 1]; ++e) {
        const std::uint64_t other = view.ids[view.second[e]];
        CHECK(e == view.begin[k] || other > last);  // by id
        last = other;
        found.insert({view.ids[k], other});
      }
    }
    return found;
  }
  std::set<std::pair<std::uint64_t, std::uint64_t>> touching() const {
    std::set<std::pair<std::uint64_t, std::uint64_t>> found;
    for (std::size_t i = 0; i < flock.own; ++i) {
      for (std::size_t j = 0; j < flock.size(); ++j) {
        double r2 = 0;
        for (std::size_t c = 0; c < 3; ++c) r2 += std::pow(double{flock.column[c][i]} - double{flock.column[c][j]}, 2);
        const double both =
            double{flock.column[interactions::radius][i]} + double{flock.column[interactions::radius][j]};
        if (i != j && r2 < both * both) found.insert({flock.ids[i], flock.ids[j]});
      }
    }
    return found;
  }
};

bool all_in(const std::set<std::pair<std::uint64_t, std::uint64_t>>& some,
            const std::set<std::pair<std::uint64_t, std::uint64_t>>& all) {
  return std::includes(all.begin(), all.end(), some.begin(), some.end());
}

// Returns spheres with ids from 1 on: 0 means "no pair before".
Flock spheres(std::size_t count, std::uint64_t seed) {
  Flock flock = test::random_flock(count, 0.5f, seed);
  for (std::uint64_t& id : flock.ids) ++id;
  return flock;
}

}  // namespace

TEST(lists_have_all_pairs_that_touch_for_as_long_as_they_hold) {
  test::Dice dice(1);
  Flock flock = spheres(400, 2);
  flock.own = 300;  // the others are ghosts
  Listed some(flock);
  int kept = 0, made = 0;
  for (std::uint32_t now = 1; now < 120; ++now) {
    (some.meet(now) ? kept : made) += 1;
    const auto listed = some.listed();
    CHECK(all_in(some.touching(), listed));
    some.list.view(now);
    const float way = now < 60 ? 2e-4f : 5e-3f;
    for (std::size_t c = 0; c < 3; ++c) {
      for (float& x : some.flock.column[c]) x += dice.between(-way, way);
    }
    if (now == 90) some.flock.column[interactions::radius][7] *= 1.5f;  // a sphere grows
  }
  CHECK(kept > 60);
  CHECK(made > 2);
}

TEST(a_list_is_made_anew_when_something_has_moved_by_half_of_the_skin) {
  for (const bool grows : {false, true}) {
    Listed some(spheres(50, 3));
    CHECK(!some.meet(1));
    CHECK(some.meet(2));
    (grows ? some.flock.column[interactions::radius] : some.flock.column[1])[11] += 0.06f * some.reach();
    CHECK(!some.meet(3));
    some.flock.column[0][3] = std::nanf("");  // touches no other
    some.flock.column[0][4] = std::nanf("");
    CHECK(some.meet(4));
    some.flock.column[0][4] = 1.5f;
    CHECK(!some.meet(5));
    CHECK(!some.meet(7));  // no meeting in sub-step 6
    std::swap(some.flock.ids[0], some.flock.ids[1]);
    CHECK(!some.meet(8));
  }
}

TEST(a_list_holds_when_grains_cross_the_ends_of_space) {
  Listed some(spheres(50, 3));
  CHECK(!some.meet(1));
  const particles::Periods periods{1, {{{-0.5f, 0.5f}, {}, {}}}};
  const interactions::Radii radii{0, some.sizes(), {nullptr, nullptr, 1}, false};
  const particles::IdList ids = some.flock.own_ids();
  const auto holds = [&](std::uint32_t now, const particles::Periods& ends) {
    const bool kept = some.list.holds(some.flock.crowd(ids), radii, now, threads::alone(), ends);
    some.list.view(now);
    return kept;
  };
  for (float& x : some.flock.column[0]) x += x < 0 ? 1.0f : -1.0f;
  CHECK(holds(2, periods));
  CHECK(some.list.wear().step < 1e-5f);
  some.flock.column[0][9] += 0.06f * some.reach();
  CHECK(!holds(3, periods));
  CHECK(!holds(4, {}));
}

TEST(any_number_of_touches_is_remembered_from_list_to_list_and_in_the_store) {
  Flock flock = spheres(31, 4);
  for (std::size_t i = 0; i < flock.size(); ++i) {  // thirty spheres around one
    const auto turn = static_cast<float>(i);
    flock.column[0][i] = i == 0 ? 0 : std::cos(turn);
    flock.column[1][i] = i == 0 ? 0 : std::sin(turn);
    flock.column[2][i] = 0;
    flock.column[interactions::radius][i] = i == 0 ? 0.99f : 0.02f;
  }
  Listed some(flock);
  some.meet(1);
  const interactions::PairsView view = some.list.view(1);
  for (std::size_t e = 0; e < some.list.pairs(); ++e) view.state[e] = {{1, static_cast<float>(e), 2}, {3, 4, 5}, 1, 0};
  const auto remembered = [](const NeighbourList& list) {
    std::vector<std::vector<particles::Touch>> all;
    for (std::size_t k = 0; k < list.ids().size(); ++k) list.recall(k, 0, all.emplace_back());
    return all;
  };
  const auto before = remembered(some.list);
  CHECK(std::max_element(before.begin(), before.end(), [](auto& a, auto& b) { return a.size() < b.size(); })->size() ==
        30);
  for (std::size_t k = 0; k < before.size(); ++k) some.store.set_touches(some.list.cells().order()[k], before[k]);
  Listed later(flock);
  later.store = some.store;
  std::swap(some.flock.ids[4], some.flock.ids[5]);  // rebuilt from the one before
  std::swap(later.flock.ids[4], later.flock.ids[5]);
  for (const auto& column : {interactions::at_x, interactions::at_y}) {
    std::swap(some.flock.column[static_cast<std::size_t>(column)][4],
              some.flock.column[static_cast<std::size_t>(column)][5]);
    std::swap(later.flock.column[static_cast<std::size_t>(column)][4],
              later.flock.column[static_cast<std::size_t>(column)][5]);
  }
  const std::vector<std::uint32_t> order = [] {
    std::vector<std::uint32_t> all;
    for (std::uint32_t i = 0; i < 31; ++i) all.push_back(i == 4 ? 5 : i == 5 ? 4 : i);
    return all;
  }();
  later.store.permute(order);
  CHECK(!some.meet(2));
  CHECK(!later.meet(2));
  const auto states = [](Listed& listed) {
    std::vector<float> all;
    const interactions::PairsView pairs = listed.list.view(2);
    for (std::size_t e = 0; e < listed.list.pairs(); ++e)
      all.push_back(pairs.state[e].slid[1] + static_cast<float>(pairs.state[e].step));
    return all;
  };
  CHECK(states(some) == states(later));
  CHECK(states(some)[5] > 1);
}

}  // namespace motes::test_neighbour_list
