// Where particles belong, and which rank plays which role.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "domains/divide.h"
#include "domains/domains.h"
#include "roles/cast.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_domains {
using domains::Domains;

namespace {
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Returns the owner of x along the first axis.
int at(const Domains& d, float x) { return d.owner_of({x, 0, 0}, 0); }
}  // namespace

TEST(domains_are_half_open_and_reach_to_infinity) {
  const Domains d({-1, 0, 2});
  CHECK(d.count() == 4);
  CHECK(at(d, -1.5f) == 0 && at(d, -1) == 1 && at(d, std::nextafter(-1.0f, -2.0f)) == 0);
  CHECK(at(d, 0) == 2 && at(d, -0.0f) == 2 && at(d, 1.999f) == 2 && at(d, 2) == 3);
  CHECK(at(d, -kInf) == 0 && at(d, kInf) == 3 && at(d, kNaN) == 3);
  CHECK(d.low(0) == -kInf && d.high(0) == -1 && d.low(3) == 2 && d.high(3) == kInf);
  CHECK(Domains().count() == 1 && at(Domains(), 5) == 0 && at(Domains(), kNaN) == 0);
  test::Dice dice(5);
  for (int i = 0; i < 10000; ++i) {
    const float x = dice.between(-3, 3);
    const int owner = at(d, x);
    CHECK(x >= d.low(owner) && x < d.high(owner));
    CHECK(d.box(owner).low[0] == d.low(owner) && d.box(owner).high[0] == d.high(owner));
  }
}

TEST(domains_may_be_empty_but_must_ascend) {
  const Domains d({0, 0, 1});
  CHECK(at(d, 0) == 2 && at(d, -1e-30f) == 0);
  CHECK_THROWS(Domains({1, 0}), std::invalid_argument);
  CHECK_THROWS(Domains({kNaN}), std::invalid_argument);
  CHECK_THROWS(Domains({0, kNaN, 1}), std::invalid_argument);
}

TEST(equal_slices_share_the_space) {
  const Domains d = domains::equal_slices(-3, 3, 3);
  CHECK(d.cuts() == std::vector<float>({-1, 1}));
  CHECK(domains::equal_slices(0, 1, 1).count() == 1);
  const Domains many = domains::equal_slices(-domains::kInfinite, domains::kInfinite, 16);
  for (std::size_t i = 1; i < many.cuts().size(); ++i) CHECK(many.cuts()[i] - many.cuts()[i - 1] == 131072);
  CHECK(domains::equal_slices(1, 1 + 1e-9, 5).count() == 5);
}

TEST(quantiles_hold_equally_many) {
  test::Dice dice(6);
  for (const int count : {2, 3, 5, 8}) {
    std::vector<float> x;
    for (int i = 0; i < 4001; ++i) x.push_back(dice.between(-1, 1) * dice.between(0, 100));
    const Domains d = domains::quantiles(x, count);
    std::vector<int> held(static_cast<std::size_t>(count));
    for (const float v : x) ++held[static_cast<std::size_t>(at(d, v))];
    const auto [least, most] = std::minmax_element(held.begin(), held.end());
    CHECK(*most - *least <= 2);
  }
}

TEST(quantiles_of_odd_coordinates) {
  CHECK(domains::quantiles({}, 4).cuts() == domains::equal_slices(-1048576, 1048576, 4).cuts());
  const std::vector<float> same(100, 2.5f);
  CHECK(domains::quantiles(same, 3).cuts() == std::vector<float>({2.5f, 2.5f}));
  const std::vector<float> odd{kNaN, 1, kInf, -kInf, 2, kNaN, 3};
  CHECK(domains::quantiles(odd, 5).count() == 5);
  const std::vector<float> few{7};
  CHECK(domains::quantiles(few, 4).count() == 4);
}

TEST(cast_by_number_of_ranks) {
  using roles::Cast;
  CHECK((roles::cast_auto(1) == Cast{0, 0, {0}}));
  CHECK((roles::cast_auto(2) == Cast{0, 0, {1}}));
  CHECK((roles::cast_auto(3) == Cast{1, 0, {2}}));
  CHECK((roles::cast_auto(5) == Cast{1, 0, {2, 3, 4}}));
  CHECK((roles::cast_shared(1) == Cast{0, 0, {0}}));
  CHECK((roles::cast_shared(3) == Cast{0, 0, {0, 1, 2}}));
  for (int size = 1; size < 9; ++size) {
    roles::check(roles::cast_auto(size), size);
    roles::check(roles::cast_shared(size), size);
  }
}

TEST(cast_is_checked_and_described) {
  const roles::Cast cast{1, 2, {4, 2}};
  roles::check(cast, 5);
  CHECK(cast.describe(0) == "spectator" && cast.describe(1) == "manager" && cast.describe(4) == "calculator 0");
  CHECK(cast.describe(2) == "image generator, calculator 1");
  CHECK(cast.calculator_of(2) == 1 && cast.calculator_of(3) == -1);
  CHECK_THROWS(roles::check(cast, 4), std::invalid_argument);
  CHECK_THROWS(roles::check({0, 0, {}}, 1), std::invalid_argument);
  CHECK_THROWS(roles::check({0, 0, {1, 1}}, 2), std::invalid_argument);
  CHECK_THROWS(roles::check({-1, 0, {0}}, 2), std::invalid_argument);
  CHECK_THROWS(roles::check({0, 2, {0}}, 2), std::invalid_argument);
}

}  // namespace motes::test_domains
