// Cuts of bricks from particles counted in boxes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "balance/cells.h"
#include "domains/divide.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_balance_trees {
using balance::Cell;
using domains::Axes;
using domains::Cut;
using domains::Domains;
using domains::Places;

namespace {

struct Cloud {
  std::array<std::vector<float>, 3> at;

  Places places() const { return {{at[0].data(), at[1].data(), at[2].data()}, {}, at[0].size()}; }
  void add(float x, float y, float z) {
    at[0].push_back(x);
    at[1].push_back(y);
    at[2].push_back(z);
  }
};

// Returns points, dense in the middle and thin outside.
Cloud cloud(std::size_t count, test::Dice& dice) {
  Cloud made;
  for (std::size_t i = 0; i < count; ++i) {
    const float wide = dice.between(0, 1) * dice.between(0, 1);
    made.add(7 + 3 * wide * dice.between(-1, 1), wide * dice.between(-1, 2), 100 * wide * dice.between(-1, 1));
  }
  return made;
}

std::vector<Cloud> dealt(const Cloud& all, const Domains& domains) {
  std::vector<std::uint32_t> owners(all.at[0].size());
  domains.owners_of(all.places(), owners.data());
  std::vector<Cloud> parts(static_cast<std::size_t>(domains.count()));
  for (std::size_t p = 0; p < owners.size(); ++p) parts[owners[p]].add(all.at[0][p], all.at[1][p], all.at[2][p]);
  return parts;
}

// Counts each part in as many cells as a frame uses: more if it has more particles.
std::vector<std::vector<Cell>> counted(const std::vector<Cloud>& parts, Axes axes, std::size_t count) {
  std::vector<std::vector<Cell>> all;
  for (const Cloud& part : parts) {
    const std::size_t most = (512 + 128 * parts.size()) * part.at[0].size() / count;
    all.push_back(balance::cells(axes, part.places(), static_cast<int>(most)));
  }
  return all;
}

}  // namespace

TEST(cells_hold_all_particles_and_are_no_larger_than_they) {
  test::Dice dice(51);
  for (const std::uint8_t bits : {3, 5, 6, 7}) {
    for (const std::size_t count : {0, 1, 7, 5000}) {
      Cloud all = cloud(count, dice);
      const auto cells = balance::cells({bits}, all.places(), 40);
      CHECK(cells.size() <= 40 && (count < 1000 || cells.size() > 35));
      std::uint64_t held = 0, most = 0;
      for (const Cell& cell : cells) {
        held += cell.count;
        most = std::max(most, cell.count);
        std::uint64_t inside = 0;
        for (std::size_t p = 0; p < count; ++p) {
          bool in = true;
          for (std::size_t a = 0; a < 3; ++a) {
            const bool cut = ((bits >> a) & 1) != 0;
            in = in && (!cut || (all.at[a][p] >= cell.low[a] && all.at[a][p] <= cell.high[a]));
          }
          inside += static_cast<std::uint64_t>(in);
        }
        CHECK(inside == cell.count);  // boxes do not overlap
      }
      CHECK(held == count && most <= 2 * count / 40 + 1);
    }
  }
  Cloud odd;
  odd.add(std::numeric_limits<float>::quiet_NaN(), 0, 0);
  odd.add(1, 2, std::numeric_limits<float>::infinity());
  CHECK(balance::cells({7}, odd.places(), 8).empty() && balance::cells({3}, odd.places(), 8).size() == 1);
}

TEST(tree_cuts_give_each_domain_its_share) {
  test::Dice dice(52);
  for (const std::uint8_t bits : {3, 5, 6, 7}) {
    for (const int count : {2, 3, 5, 8, 12}) {
      const Cloud all = cloud(40000, dice);
      Domains domains = domains::equal_parts({bits}, -domains::kInfinite, domains::kInfinite, count);
      std::vector<double> shares;
      for (int c = 0; c < count; ++c) shares.push_back(1 + c % 3);
      const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
      for (int times = 0; times < 2; ++times) {
        domains = balance::tree_cuts(counted(dealt(all, domains), {bits}, 40000), {}, shares, domains);
        const std::vector<Cloud> parts = dealt(all, domains);
        for (std::size_t c = 0; c < parts.size(); ++c) {
          const double got = static_cast<double>(parts[c].at[0].size()) / 40000 * sum / shares[c];
          CHECK_NEAR(got, 1, times == 0 ? 0.2 : 0.06);
        }
      }
    }
  }
}

TEST(tree_cuts_keep_axes_and_count_costs) {
  const Domains before = Domains::of({{0, -1}, {1, 5}, {0, 1}});
  const std::vector<std::vector<Cell>> cells{{{{0, 0, 0}, {1, 1, 0}, 100}}, {}, {}, {{{2, 2, 0}, {3, 3, 0}, 100}}};
  // The left half costs three times as much: of 400, 200 lie below y = 2/3 and each quarter holds 100.
  const Domains after = balance::tree_cuts(cells, std::vector<double>{3, 1, 1, 1}, std::vector<double>(4, 1.0), before);
  const std::vector<Cut> tree = after.tree();
  CHECK(tree[0].axis == 0 && tree[1].axis == 1 && tree[2].axis == 0);
  CHECK_NEAR(tree[1].at, 2.0 / 3, 1e-6);
  CHECK_NEAR(tree[0].at, 0.5, 1e-6);
  CHECK(tree[2].at >= 1 && tree[2].at <= 2);  // in the gap: the right half has 100 below and 100 above
  CHECK_THROWS(balance::tree_cuts(cells, {}, std::vector<double>(3, 1.0), before), std::invalid_argument);
}

TEST(tree_cuts_stay_where_nothing_is_and_in_gaps) {
  const Domains before = Domains::of({{0, -1}, {1, 5}, {0, 1}});
  const std::vector<std::vector<Cell>> none(4);
  CHECK(balance::tree_cuts(none, {}, std::vector<double>(4, 1.0), before) == before);
  CHECK(balance::tree_cuts(none, {}, std::vector<double>(4, 0.0), before) == before);
  const std::vector<std::vector<Cell>> two{{{{0, 0, 0}, {1, 1, 0}, 10}}, {}, {}, {{{0, 9, 0}, {1, 9.5, 0}, 10}}};
  const Domains after = balance::tree_cuts(two, {}, std::vector<double>(4, 1.0), before);
  CHECK(after.cuts()[1] == 5);  // any cut between 1 and 9 is right, so it stays
  CHECK_NEAR(after.cuts()[0], 0.5, 1e-6);
  CHECK_NEAR(after.cuts()[2], 0.5, 1e-6);
  const Domains all = balance::tree_cuts(two, {}, std::vector<double>{0, 0, 1, 1}, before);
  CHECK(all.cuts()[1] < 1e-6f);  // nothing below
}

TEST(tree_cuts_of_particles_in_one_place) {
  const Domains before = domains::equal_parts({3}, -1, 1, 4);
  const std::vector<std::vector<Cell>> heap{{{{2, 2, 0}, {2, 2, 0}, 1000}}, {}, {}, {{{-8, -8, 0}, {-7, -7, 0}, 10}}};
  const Domains after = balance::tree_cuts(heap, {}, std::vector<double>(4, 1.0), before);
  CHECK(after.count() == 4);
  // Particles at one place stay together, so planning again changes nothing.
  CHECK(balance::tree_cuts(heap, {}, std::vector<double>(4, 1.0), after) == after);
}

}  // namespace motes::test_balance_trees
