// Bricks and parts of the ids: trees of cuts, compared with the boxes that they make.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>

#include "domains/divide.h"
#include "domains/test_domains_boxes.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_domain_trees {
using domains::Axes;
using domains::Box;
using domains::Cut;
using domains::Domains;
using domains_test::holds;
using domains_test::kInf;
using domains_test::kNaN;
using domains_test::Place;

namespace {

// Grows a tree over domains first .. last - 1, whose cuts lie inside the boxes that they halve, now and then on a face.
void grow(std::vector<Cut>& tree, int first, int last, const Box& box, Axes axes, test::Dice& dice) {
  if (last - first < 2) return;
  int axis = static_cast<int>(dice.below(3));
  while (!axes.has(axis)) axis = (axis + 1) % 3;
  const auto a = static_cast<std::size_t>(axis);
  const float low = std::max(box.low[a], -4.0f);
  const float high = std::min(box.high[a], 4.0f);
  const float at = dice.below(6) == 0 ? low : std::clamp(dice.between(low, high), low, high);
  const int middle = first + domains::left_part(last - first);
  tree[static_cast<std::size_t>(middle - 1)] = {axis, at};
  Box left = box, right = box;
  left.high[a] = right.low[a] = at;
  grow(tree, first, middle, left, axes, dice);
  grow(tree, middle, last, right, axes, dice);
}

Domains random_tree(int count, Axes axes, test::Dice& dice) {
  std::vector<Cut> tree(static_cast<std::size_t>(count) - 1);
  grow(tree, 0, count, {}, axes, dice);
  return Domains::of(tree);
}

// Returns a place anywhere or, as often, on cuts.
Place random_place(const Domains& d, test::Dice& dice) {
  Place p{dice.between(-5, 5), dice.between(-5, 5), dice.between(-5, 5)};
  for (int i = 0; i < 3 && d.count() > 1; ++i) {
    const std::vector<Cut> tree = d.tree();
    const Cut& cut = tree[dice.below(static_cast<std::uint32_t>(tree.size()))];
    const float beside[] = {cut.at, std::nextafter(cut.at, -kInf), std::nextafter(cut.at, kInf), p[0]};
    p[static_cast<std::size_t>(cut.axis)] = beside[dice.below(4)];
  }
  return p;
}

std::vector<int> counts(const Domains& d, const domains::Places& places) {
  std::vector<std::uint32_t> owners(places.count);
  d.owners_of(places, owners.data());
  std::vector<int> held(static_cast<std::size_t>(d.count()));
  for (const std::uint32_t owner : owners) ++held.at(owner);
  return held;
}

}  // namespace

TEST(boxes_of_a_tree_share_space_and_say_who_owns_what) {
  test::Dice dice(41);
  for (int round = 0; round < 400; ++round) {
    const Axes axes{static_cast<std::uint8_t>(1 + dice.below(7))};
    const Domains d = random_tree(1 + static_cast<int>(dice.below(40)), axes, dice);
    std::vector<Box> boxes;
    for (int c = 0; c < d.count(); ++c) boxes.push_back(d.box(c));
    for (int i = 0; i < 50; ++i) {
      const Place p = random_place(d, dice);
      const int owner = d.owner_of(p, 0);
      for (int c = 0; c < d.count(); ++c) CHECK(holds(boxes[static_cast<std::size_t>(c)], p) == (c == owner));
    }
  }
}

TEST(many_have_the_owners_that_each_has) {
  test::Dice dice(42);
  for (int round = 0; round < 100; ++round) {
    const Axes axes{static_cast<std::uint8_t>(dice.below(8))};
    const int count = 1 + static_cast<int>(dice.below(70));
    const Domains d = axes.by_id() ? domains::equal_parts(axes, 0, 0, count) : random_tree(count, axes, dice);
    const std::size_t n = dice.below(100);
    std::array<std::vector<float>, 3> planes;
    std::vector<std::uint64_t> ids;
    for (std::size_t p = 0; p < n; ++p) {
      const Place place = random_place(axes.by_id() ? Domains() : d, dice);
      for (std::size_t a = 0; a < 3; ++a) planes[a].push_back(dice.below(40) == 0 ? kNaN : place[a]);
      ids.push_back(std::uint64_t{dice.below(1u << 31)} << dice.below(30));
    }
    std::vector<std::uint32_t> owners(n);
    const particles::IdList halves(ids);
    d.owners_of({{planes[0].data(), planes[1].data(), planes[2].data()}, halves, n}, owners.data());
    for (std::size_t p = 0; p < n; ++p) {
      CHECK(static_cast<int>(owners[p]) == d.owner_of({planes[0][p], planes[1][p], planes[2][p]}, ids[p]));
    }
  }
}

TEST(a_tree_of_one_axis_is_slabs) {
  test::Dice dice(43);
  for (int round = 0; round < 100; ++round) {
    const int axis = static_cast<int>(dice.below(3));
    const Domains tree =
        random_tree(1 + static_cast<int>(dice.below(20)), {static_cast<std::uint8_t>(1 << axis)}, dice);
    const Domains slabs(tree.cuts(), tree.count() == 1 ? 0 : axis);
    CHECK(tree == slabs && tree.tree() == slabs.tree());
  }
}

TEST(trees_give_what_is_no_number_to_the_far_side_of_each_cut) {
  const Domains d = Domains::of({{1, 0}, {0, 0}, {1, 1}});  // x at 0; to its left y at 0, to its right y at 1
  CHECK(d.count() == 4 && d.axis() == -1 && d.halved() == 0);
  CHECK(d.owner_of({-1, -1, 0}, 0) == 0 && d.owner_of({-1, 0, 0}, 0) == 1);
  CHECK(d.owner_of({0, 0, 0}, 0) == 2 && d.owner_of({0, 1, 0}, 0) == 3);
  CHECK(d.owner_of({kNaN, kNaN, kNaN}, 0) == 3 && d.owner_of({-1, kNaN, 0}, 0) == 1);
  CHECK(d.owner_of({kNaN, 0, 0}, 0) == 2 && d.owner_of({kInf, -kInf, 0}, 0) == 2);
}

TEST(trees_that_are_none_are_refused) {
  CHECK_THROWS(Domains::of({{0, 1}, {0, 0}}), std::invalid_argument);  // does not ascend
  CHECK_THROWS(Domains::of({{0, 1}, {0, 0}, {1, 0}}), std::invalid_argument);  // left of 0 at 1
  CHECK_THROWS(Domains::of({{1, kNaN}, {0, 0}, {1, 0}}), std::invalid_argument);
  CHECK_THROWS(Domains::of({{4, 0}}), std::invalid_argument);
  CHECK_THROWS(Domains::of({{-1, 0}}), std::invalid_argument);
  CHECK_THROWS(Domains::of({{1, 0}, {domains::kById, 0}}), std::invalid_argument);
}

TEST(equal_bricks_have_equal_volumes) {
  for (const std::uint8_t bits : {3, 5, 6, 7}) {
    for (int count = 1; count <= 33; ++count) {
      const Domains d = domains::equal_parts({bits}, -3, 5, count);
      double all = 0;
      for (int c = 0; c < count; ++c) {
        const Box box = d.box(c);
        double volume = 1;
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          if (((bits >> axis) & 1) == 0) {
            CHECK(box.low[a] == -kInf && box.high[a] == kInf);
            continue;
          }
          volume *= (std::min(box.high[a], 5.0f) - std::max(box.low[a], -3.0f)) / 8.0;
        }
        CHECK_NEAR(volume * count, 1, 1e-5);
        all += volume;
      }
      CHECK_NEAR(all, 1, 1e-5);
    }
  }
  const Domains d = domains::equal_parts({3}, 0, 1, 4);
  CHECK(d.tree() == std::vector<Cut>({{1, 0.5f}, {0, 0.5f}, {1, 0.5f}}));
  CHECK(domains::equal_parts({7}, -domains::kInfinite, domains::kInfinite, 8).halved() == 0);
}

TEST(fitted_bricks_hold_equally_many) {
  test::Dice dice(44);
  for (const std::uint8_t bits : {1, 2, 4, 3, 5, 6, 7}) {
    for (const int count : {1, 2, 3, 5, 8, 13}) {
      std::array<std::vector<float>, 3> planes;
      for (int i = 0; i < 4000; ++i) {
        for (std::size_t a = 0; a < 3; ++a)
          planes[a].push_back(dice.between(-1, 1) * dice.between(0, a == 1 ? 1e8f : 9));
      }
      const domains::Places places{{planes[0].data(), planes[1].data(), planes[2].data()}, {}, 4000};
      const std::vector<int> held = counts(domains::quantiles({bits}, places, count), places);
      const auto [least, most] = std::minmax_element(held.begin(), held.end());
      CHECK(*most - *least <= 4);
    }
  }
}

TEST(fitted_bricks_of_odd_places) {
  const std::vector<float> x{kNaN, 1, kInf, -kInf, 2, kNaN, 3e7f, 3e7f}, y{0, kNaN, 1, 1, 1, kNaN, -kInf, 3e8f};
  for (int count = 1; count < 20; ++count) {
    const domains::Places odd{{x.data(), y.data(), y.data()}, {}, x.size()};
    CHECK(domains::quantiles({3}, odd, count).count() == count);
    CHECK(domains::quantiles({7}, odd, count).count() == count);
  }
  const domains::Places none{};
  CHECK(domains::quantiles({7}, none, 5) == domains::equal_parts({7}, -domains::kInfinite, domains::kInfinite, 5));
}

TEST(ids_are_dealt_out_evenly) {
  for (const int count : {1, 2, 3, 7, 64}) {
    const Domains d = domains::equal_parts({0}, -1, 1, count);
    CHECK(d.axis() == domains::kById && d.box(0) == Box{});
    for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{1} << 40}) {
      for (const std::uint64_t stride : {1, 2, 3}) {
        std::vector<std::uint64_t> ids(6400);
        for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = first + stride * i;
        const particles::IdList halves(ids);
        const std::vector<int> held = counts(d, {{}, halves, ids.size()});
        const auto [least, most] = std::minmax_element(held.begin(), held.end());
        CHECK(*most - *least <= 10);
      }
    }
  }
  CHECK(domains::scattered(0) == 0 && domains::scattered(UINT64_MAX) < 1);
}

TEST(only_the_axes_that_are_cut_must_be_there) {
  const std::vector<float> y{-1, 1, -1, 1, 0};
  const std::vector<float> z{-1, -1, 1, 1, 0};
  domains::Places places;
  places.position = {nullptr, y.data(), z.data()};
  places.count = y.size();
  for (const int count : {3, 5, 6}) {  // trees of which some branches are shorter
    std::vector<domains::Cut> tree;
    for (int i = 1; i < count; ++i) tree.push_back({i % 2 == 0 ? 1 : 2, 0});
    const auto made = domains::Domains::of(tree);
    std::vector<std::uint32_t> owners(places.count);
    made.owners_of(places, owners.data());
    for (std::size_t i = 0; i < places.count; ++i)
      CHECK(static_cast<int>(owners[i]) == made.owner_of({9, y[i], z[i]}, 0));
  }
}

}  // namespace motes::test_domain_trees
