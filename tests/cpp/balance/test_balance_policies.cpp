// The paper's rules of balancing (3.2.5), and what the other policies promise.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include "balance/named.h"
#include "support/check.h"

namespace motes::test_balance_policies {
using namespace balance;

namespace {

LoadTable table_of(std::vector<Load> loads, std::uint64_t evaluation = 0) {
  LoadTable table;
  table.frame = 7;
  table.evaluation = evaluation;
  table.system = "snow";
  table.cuts.resize(loads.empty() ? 0 : loads.size() - 1);
  table.loads = std::move(loads);
  return table;
}

std::vector<Load> loads_of(std::initializer_list<std::uint64_t> counts) {
  std::vector<Load> loads;
  for (const std::uint64_t n : counts) loads.push_back({n, static_cast<double>(n) * 1e-6, 1e6});
  return loads;
}

std::vector<Load> half_fast(std::size_t calculators, std::uint64_t each) {
  std::vector<Load> loads;
  for (std::size_t c = 0; c < calculators; ++c) loads.push_back({each, 0, c < calculators / 2 ? 2e6 : 1e6});
  return loads;
}

// Executes orders as if every donor could give exactly the number in the order.
void obey(std::vector<Load>& loads, const Plan& plan) {
  for (const Order& order : plan.orders) {
    loads[static_cast<std::size_t>(order.from)].particles -= order.count;
    loads[static_cast<std::size_t>(order.to)].particles += order.count;
  }
}

double after(const Policy& policy, std::vector<Load> loads, int evaluations) {
  for (int i = 0; i < evaluations; ++i) {
    const LoadTable table = table_of(loads, static_cast<std::uint64_t>(i));
    obey(loads, legal(policy.plan(table), table, policy.name()));
  }
  return imbalance(loads);
}

std::string refusal(const Plan& plan, const LoadTable& table) {
  try {
    (void)legal(plan, table, "Even()");
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

std::shared_ptr<Policy> pairwise(double threshold, std::uint64_t least, const std::vector<double>& powers = {}) {
  return policy_made("Pairwise", {{"threshold", threshold}, {"powers", powers}, {"min_particles", least}});
}

std::shared_ptr<Policy> diffusive(double threshold, double rate, std::uint64_t least) {
  return policy_made("Diffusive", {{"threshold", threshold}, {"rate", rate}, {"min_particles", least}});
}

std::shared_ptr<Policy> prefix_cuts(double threshold, const std::vector<double>& powers, std::uint64_t least) {
  return policy_made("PrefixCuts", {{"threshold", threshold}, {"powers", powers}, {"min_particles", least}});
}

std::shared_ptr<Policy> proportional(const std::vector<double>& powers, double threshold, std::uint64_t least) {
  return policy_made("Proportional", {{"threshold", threshold}, {"powers", powers}, {"min_particles", least}});
}

TEST(load_is_rescaled_and_small_samples_do_not_count) {
  CHECK(rescaled(2.0, 100, 150) == 3.0);
  CHECK(rescaled(2.0, 0, 150) == 2.0);
  CHECK(rescaled(2.0, 100, 0) == 0.0);
  Speeds speeds(2, {0.75, 1e-3, 100});
  CHECK(speeds.of(0) == 0);
  speeds.add(0, 99, 1.0);  // too few
  speeds.add(0, 1000, 1e-4);  // too short
  speeds.add(0, 1000, 0);  // no time
  speeds.add(0, 1000, std::numeric_limits<double>::quiet_NaN());  // NaN
  CHECK(speeds.of(0) == 0);
  speeds.add(0, 1000, 0.1, 501);  // mostly born in this frame
  CHECK(speeds.of(0) == 0);
  speeds.add(0, 1000, 0.5, 500);
  CHECK(speeds.of(0) == 2000);
  CHECK(speeds.error(0) == 0);
  speeds.add(0, 1000, 1.0);
  CHECK(speeds.of(0) == 2000);  // the faster of the first two
  speeds.add(0, 1000, 0.8);
  CHECK(speeds.of(0) == 1625);  // its mean with the median of three
  CHECK(speeds.of(1) == 0);
}

TEST(speeds_follow_a_step) {
  for (const double smoothing : {0.0, 0.5, 0.75}) {
    Speeds speeds(1, {smoothing, 0, 0});
    for (int i = 0; i < 20; ++i) speeds.add(0, 1000, 1.0);
    CHECK(speeds.of(0) == 1000);
    CHECK(speeds.error(0) == 0);
    speeds.add(0, 2000, 1.0);  // the step itself looks like noise, so everything known so far may still count
    CHECK(speeds.of(0) <= smoothing * 1000 + (1 - smoothing) * 2000 + 1e-9);
    for (int i = 0; i < 60; ++i) speeds.add(0, 2000, 1.0);
    CHECK(std::abs(speeds.of(0) - 2000) < 20);
  }
}

TEST(errors_are_those_of_the_noise) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const double noise : {0.02, 0.1}) {
    double squares = 0;
    double told = 0;
    for (int run = 0; run < 400; ++run) {
      Speeds speeds(1, {0.5, 0, 0});
      for (int i = 0; i < 40; ++i) speeds.add(0, 1000, std::exp(noise * normal(random)));
      const double off = speeds.of(0) / 1000 - 1;
      squares += off * off;
      told += speeds.error(0) * speeds.error(0);
    }
    CHECK(std::sqrt(squares / 400) < 0.36 * noise);  // 0.58 with weight 1/2 per sample, 0.26 with 1/8
    CHECK(std::sqrt(told / squares) > 0.75);
    CHECK(std::sqrt(told / squares) < 1.25);
  }
}

TEST(a_slow_start_is_forgotten_soon) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Speeds speeds(1, {0.5, 0, 0});
  speeds.add(0, 1000, 10);
  for (int i = 0; i < 12; ++i) speeds.add(0, 1000, std::exp(0.05 * normal(random)));
  CHECK(std::abs(speeds.of(0) / 1000 - 1) < 0.1);
  CHECK(speeds.error(0) < 0.1);
}

TEST(a_change_beyond_noise_is_believed_soon) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (const double noise : {0.01, 0.05}) {
    Speeds speeds(1, {0.5, 0, 0});
    for (int i = 0; i < 40; ++i) speeds.add(0, 1000, std::exp(noise * normal(random)));
    for (int i = 0; i < 6; ++i) speeds.add(0, 1000, 2 * std::exp(noise * normal(random)));
    CHECK(std::abs(speeds.of(0) / 500 - 1) < 0.15);
  }
}

TEST(what_disturbs_for_a_few_frames_is_not_believed) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  for (const double noise : {0.0, 0.02, 0.05}) {
    Speeds speeds(1, {0.5, 0, 0});
    for (int i = 0; i < 60; ++i) speeds.add(0, 1000, std::exp(noise * normal(random)));
    const double before = speeds.of(0);
    for (int i = 0; i < 4; ++i) speeds.add(0, 1000, 1.7 * std::exp(noise * normal(random)));
    CHECK(std::abs(speeds.of(0) / before - 1) < 0.03 + 2 * noise);
    for (int i = 0; i < 3; ++i) speeds.add(0, 1000, 1.7 * std::exp(noise * normal(random)));
    CHECK(std::abs(speeds.of(0) * 1.7 / 1000 - 1) < 0.05 + 2 * noise);  // the change lasts
  }
}

TEST(differences_within_noise_are_left_alone) {
  const auto apart = [](double error) {
    return table_of({{1100, 0, 1, error}, {900, 0, 1, 0}, {1000, 0, 1, 0}});  // 18 % in the first pair
  };
  CHECK(doubt({1, 0, 1, 0.03}, {1, 0, 1, 0.04}) == kErrors * 0.05);
  CHECK(!pairwise(0.1, 1)->plan(apart(0.06)).orders.empty());
  CHECK(pairwise(0.1, 1)->plan(apart(0.061)).orders.empty());
  CHECK(diffusive(0.01, 1, 1)->plan(apart(0.06)).orders.size() == 2);
  CHECK(diffusive(0.01, 1, 1)->plan(apart(0.061)).orders.size() == 1);
  // Three calculators: noise explains up to 3.35 standard errors of the largest of three.
  CHECK(!prefix_cuts(0.05, {}, 1)->plan(apart(0.0298)).shares.empty());
  CHECK(prefix_cuts(0.05, {}, 1)->plan(apart(0.03)).shares.empty());
}

TEST(unknown_speeds_are_the_mean_of_the_known) {
  CHECK(complete({{1, 0, 0}, {1, 0, 0}}) == std::vector<double>({1, 1}));
  CHECK(complete({{1, 0, 0}, {1, 0, 2}, {1, 0, 4}}) == std::vector<double>({3, 2, 4}));
  CHECK(imbalance({{0, 0, 0}, {0, 0, 0}}) == 1);
  CHECK(imbalance({}) == 1);
  CHECK(imbalance({{300, 0, 0}, {100, 0, 0}}) == 1.5);
  CHECK(imbalance({{300, 0, 3}, {100, 0, 1}}) == 1);
}

TEST(pairwise_begins_with_the_first_or_the_second_pair) {
  const auto made = pairwise(0.1, 1);
  const Policy& policy = *made;
  const std::vector<Load> loads = loads_of({1000, 0, 1000, 0, 1000});
  CHECK(policy.plan(table_of(loads, 0)).orders == std::vector<Order>({{0, 1, 500}, {2, 3, 500}}));
  CHECK(policy.plan(table_of(loads, 0)).evaluated == std::vector<std::int32_t>({0, 2}));
  CHECK(policy.plan(table_of(loads, 1)).orders == std::vector<Order>({{2, 1, 500}, {4, 3, 500}}));
  CHECK(policy.plan(table_of(loads, 1)).evaluated == std::vector<std::int32_t>({1, 3}));
  // Two calculators form one pair, which is evaluated every time.
  CHECK(policy.plan(table_of(loads_of({1000, 0}), 1)).orders.size() == 1);
}

TEST(pairwise_goes_on_with_the_next_pair_where_nothing_is_to_do) {
  const Plan plan = pairwise(0.1, 1)->plan(table_of(loads_of({1000, 1000, 1000, 0, 500}), 0));
  CHECK(plan.evaluated == std::vector<std::int32_t>({0, 1, 2}));
  CHECK(plan.orders == std::vector<Order>({{2, 3, 500}}));
}

TEST(pairwise_has_a_threshold_and_a_minimum) {
  const std::vector<Load> loads{{1000, 0, 1}, {750, 0, 1}};
  CHECK(pairwise(0.25, 1)->plan(table_of(loads)).orders.empty());  // exactly the threshold
  CHECK(pairwise(0.249, 1)->plan(table_of(loads)).orders == std::vector<Order>({{0, 1, 125}}));
  CHECK(pairwise(0.249, 125)->plan(table_of(loads)).orders.size() == 1);
  CHECK(pairwise(0.249, 126)->plan(table_of(loads)).orders.empty());
  CHECK(pairwise(0, 0)->plan(table_of(loads_of({1000, 1000}))).orders.empty());
}

TEST(pairwise_shares_by_processing_power) {
  const auto made = pairwise(0.1, 1);
  const Policy& policy = *made;
  std::vector<Load> loads{{100, 0, 3e6}, {500, 0, 1e6}};
  CHECK(policy.plan(table_of(loads)).orders == std::vector<Order>({{1, 0, 350}}));
  loads = {{0, 0, 0}, {10'000'000'000, 0, 5e6}};  // unknown: as fast as the others
  CHECK(policy.plan(table_of(loads)).orders == std::vector<Order>({{1, 0, 5'000'000'000}}));
}

TEST(policies_do_nothing_where_nothing_is_to_do) {
  const std::vector<std::shared_ptr<Policy>> policies{policy_made("Static"), pairwise(0.1, 1), diffusive(0.01, 0.8, 1),
                                                      prefix_cuts(0.05, {}, 1)};
  for (const auto& policy : policies) {
    for (const std::vector<Load>& loads :
         {loads_of({}), loads_of({0}), loads_of({12}), loads_of({0, 0, 0}), loads_of({9, 9, 9, 9})}) {
      const LoadTable table = table_of(loads);
      CHECK(policy->plan(table).empty());
      CHECK(legal(policy->plan(table), table, policy->name()).empty());
    }
  }
}

TEST(pairwise_stalls_on_a_slope_and_diffusion_does_not) {
  const std::vector<Load> loads = half_fast(16, 200'000);
  CHECK_NEAR(imbalance(loads), 4.0 / 3, 1e-12);
  CHECK(after(*pairwise(0.05, 64), loads, 1000) > 1.2);
  CHECK(after(*diffusive(0.01, 0.8, 64), loads, 1000) < 1.1);
}

TEST(diffusive_neighbours_decide_as_all_together) {
  std::mt19937_64 random(3);
  const auto made = diffusive(0.02, 1, 5);
  const Policy& policy = *made;
  CHECK(policy.decentralised());
  for (int round = 0; round < 200; ++round) {
    std::vector<Load> loads(2 + random() % 9);
    for (Load& load : loads) {
      load.particles = random() % 3 == 0 ? 0 : random() % 10000;
      load.speed = random() % 4 == 0 ? 0 : 1 + static_cast<double>(random() % 100);
    }
    const LoadTable table = table_of(loads);
    std::vector<Order> orders;
    for (std::size_t i = 0; i + 1 < loads.size(); ++i) {
      const Order order = policy.between(static_cast<std::int32_t>(i), loads[i], loads[i + 1]);
      if (order.count > 0) orders.push_back(order);
    }
    const Plan plan = policy.plan(table);
    CHECK(plan.orders == orders);
    CHECK(legal(plan, table, "").orders == orders);  // no donor gives more than it has
  }
}

TEST(diffusive_is_stable_for_any_speeds) {
  std::vector<Load> loads;
  for (int c = 0; c < 9; ++c) loads.push_back({100'000, 0, c % 2 == 0 ? 1e7 : 1e5});
  CHECK(after(*diffusive(0.001, 1, 1), loads, 400) < 1.1);
}

TEST(prefix_cuts_asks_for_shares_above_its_threshold) {
  const std::vector<Load> loads{{300, 0, 3e6}, {110, 0, 1e6}};
  CHECK(prefix_cuts(0.1, {}, 1)->plan(table_of(loads)).shares.empty());
  CHECK(prefix_cuts(0.04, {}, 1)->plan(table_of(loads)).shares == std::vector<double>({3e6, 1e6}));
  CHECK(prefix_cuts(0.04, {}, 100)->plan(table_of(loads)).shares.empty());
  // With powers, the position determines the cost: calculator 1 has the same machine but takes three times as long per
  // particle.
  const Plan plan = prefix_cuts(0.04, {2, 2, 2}, 1)->plan(table_of({{300, 0, 3e6}, {300, 0, 1e6}, {0, 0, 0}}));
  CHECK(plan.shares == std::vector<double>({2, 2, 2}));
  CHECK_NEAR(plan.costs[1] / plan.costs[0], 3, 1e-12);
  CHECK_NEAR(plan.costs[2] / plan.costs[0], 2, 1e-12);
  const auto three = prefix_cuts(0.1, {1, 1, 1}, 1);
  CHECK_THROWS(three->plan(table_of(loads)), std::invalid_argument);
}

TEST(proportional_keeps_fixed_shares) {
  const auto made = proportional({2, 1, 0}, 0.1, 10);
  const Policy& policy = *made;
  CHECK(policy.plan(table_of(loads_of({205, 95, 0}))).shares.empty());
  CHECK(policy.plan(table_of(loads_of({180, 120, 0}))).shares == std::vector<double>({2, 1, 0}));
  CHECK(policy.plan(table_of(loads_of({200, 91, 9}))).shares.empty());
  CHECK(!policy.plan(table_of(loads_of({200, 88, 12}))).shares.empty());
  CHECK_THROWS(policy.check(2), std::invalid_argument);
}

TEST(legal_nets_orders_and_limits_donors) {
  const LoadTable table = table_of(loads_of({100, 50, 10}));
  Plan plan;
  plan.orders = {{1, 0, 30}, {0, 1, 40}, {1, 2, 45}, {1, 2, 45}};
  CHECK(legal(plan, table, "").orders == std::vector<Order>({{0, 1, 10}, {1, 2, 50}}));
  plan.orders = {{1, 0, 60}, {1, 2, 40}};
  CHECK(legal(plan, table, "").orders == std::vector<Order>({{1, 0, 30}, {1, 2, 20}}));
  plan.orders = {{1, 0, 40}, {1, 2, 40}};  // it could give either, but not both
  CHECK(legal(plan, table, "").orders == std::vector<Order>({{1, 0, 25}, {1, 2, 25}}));
  constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  plan.orders = {{1, 0, most}, {1, 0, most}, {1, 2, most}};
  CHECK(legal(plan, table, "").orders == std::vector<Order>({{1, 0, 25}, {1, 2, 25}}));
  plan.orders = {{0, 1, 0}};
  CHECK(legal(plan, table, "").empty());
}

TEST(legal_makes_shares_parts_of_one) {
  const LoadTable table = table_of(loads_of({100, 50, 10}));
  Plan plan;
  plan.shares = {1e308, 0, 1e308};
  CHECK(legal(plan, table, "").shares == std::vector<double>({0.5, 0, 0.5}));
  plan.shares = {1e-320, 3e-320, 0};
  CHECK_NEAR(legal(plan, table, "").shares[1], 0.75, 1e-3);
  CHECK(legal(plan, table_of(loads_of({0, 0, 0})), "").empty());
}

TEST(legal_refuses_what_has_no_meaning) {
  const LoadTable table = table_of(loads_of({100, 50, 10}));
  Plan plan;
  plan.shares = {1, 2};
  CHECK(refusal(plan, table) == "Even(), frame 7: shares must be 3 numbers, one per calculator, got 2");
  plan.shares = {1, -2, 1};
  CHECK(refusal(plan, table) == "Even(), frame 7: shares must be finite and >= 0, got -2");
  plan.shares = {1, std::nan(""), 1};
  CHECK(!refusal(plan, table).empty());
  plan.shares = {1, std::numeric_limits<double>::infinity(), 1};
  CHECK(!refusal(plan, table).empty());
  plan.shares = {0, 0, 0};
  CHECK(!refusal(plan, table).empty());
  plan.shares = {1, 1, 1};
  plan.costs = {1, 1};
  CHECK(!refusal(plan, table).empty());
  plan.costs.clear();
  plan.orders = {{0, 1, 5}};
  CHECK(!refusal(plan, table).empty());
  plan.shares.clear();
  for (const Order& wrong : {Order{0, 2, 5}, Order{1, 1, 5}, Order{-1, 0, 5}, Order{2, 3, 5}}) {
    plan.orders = {wrong};
    CHECK(refusal(plan, table).find("Even(), frame 7: orders must be between neighbours") == 0);
  }
}

TEST(a_plan_for_all_systems_is_divided_among_them) {
  Plan plan;
  plan.orders = {{0, 1, 60}, {2, 1, 10}};
  const Plan part = part_of(plan, loads_of({25, 5, 0}), loads_of({100, 50, 10}));
  CHECK(part.orders == std::vector<Order>({{0, 1, 15}}));
  constexpr std::uint64_t many = 10'000'000'000'000;
  plan.orders = {{0, 1, many / 3}};
  CHECK(part_of(plan, loads_of({many / 4, 0}), loads_of({many, 0})).orders[0].count == many / 3 / 4);
}

namespace {

// Returns, for each policy that plans for all calculators at once, the seconds of the quickest of several plans.
std::vector<double> planning_s(int calculators) {
  std::mt19937_64 random(11);
  std::vector<Load> loads;
  for (int c = 0; c < calculators; ++c) {
    loads.push_back({random() % 1'000'000, 0, 1e6 * static_cast<double>(1 + random() % 8)});
  }
  const std::vector<double> powers(loads.size(), 1);
  const LoadTable table = table_of(loads);
  const std::vector<std::shared_ptr<Policy>> policies{pairwise(0.1, 1), diffusive(0.01, 0.8, 1),
                                                      prefix_cuts(0.05, powers, 1), proportional(powers, 0.05, 1)};
  std::vector<double> quickest;
  for (const auto& policy : policies) {
    double best = std::numeric_limits<double>::infinity();
    for (int round = 0; round < 20; ++round) {
      const auto begin = std::chrono::steady_clock::now();
      CHECK(!legal(policy->plan(table), table, policy->name()).empty());
      best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    quickest.push_back(best);
  }
  return quickest;
}

}  // namespace

// The ratio does not depend on the machine: linear growth gives about 16, quadratic growth 256.
TEST(planning_for_16_times_as_many_calculators_takes_about_16_times_as_long) {
  const std::vector<double> few = planning_s(256), many = planning_s(4096);
  for (std::size_t i = 0; i < few.size(); ++i) CHECK(many[i] < 80 * few[i]);
}

// The paper's method: the machines' powers are known before the run, and times are as measured.
TEST(pairwise_with_given_powers_compares_measured_times) {
  std::vector<Load> loads(2);
  loads[0] = {1000, 3.0, 5, 0.5};  // measured speeds and their errors do not count
  loads[1] = {1000, 1.0, 5, 0.5};
  const auto made = pairwise(0.1, 1, {1, 3});
  const Policy& policy = *made;
  CHECK(policy.plan(table_of(loads)).orders == std::vector<Order>({{0, 1, 500}}));
  loads[1].seconds = 2.75;  // less than a tenth apart
  CHECK(policy.plan(table_of(loads)).orders.empty());
  loads[0] = {500, 3.0, 0, 0};  // in proportion: nothing can be gained, whatever the clock says
  loads[1] = {1500, 1.0, 0, 0};
  CHECK(policy.plan(table_of(loads)).orders.empty());
  CHECK_THROWS(policy.check(3), std::invalid_argument);
  CHECK_THROWS(pairwise(0.1, 1, {1, 0}), std::invalid_argument);
  policy.check(2);
}

TEST(orders_are_for_domains_in_a_row) {
  LoadTable table = table_of(loads_of({1000, 0}));
  Plan plan;
  plan.orders = {{0, 1, 10}};
  for (const std::uint8_t bits : {1, 4, 16, 32}) {
    table.axes = {bits};
    CHECK(legal(plan, table, "Own()").orders.size() == 1);
  }
  for (const std::uint8_t bits : {0, 3, 5, 6, 7}) {
    table.axes = {bits};
    CHECK_THROWS(legal(plan, table, "Own()"), std::invalid_argument);
  }
  plan.orders.clear();
  plan.shares = {1, 2};
  CHECK(legal(plan, table, "Own()").shares.size() == 2);
}

TEST(bisection_moves_nothing_where_halves_are_balanced) {
  const auto policy = policy_made("Bisection");
  const Plan plan = policy->plan(table_of(loads_of({3000, 1000, 2000, 2000})));
  CHECK(plan.shares == std::vector<double>({2000, 2000, 2000, 2000}));  // the halves have 4000 each
  CHECK(policy->plan(table_of(loads_of({2000, 2010, 2000, 1990}))).empty());
  const Plan all = policy->plan(table_of(loads_of({6000, 2000, 1000, 1000})));
  CHECK(all.shares == std::vector<double>({2500, 2500, 2500, 2500}));
  const Plan right = policy->plan(table_of(loads_of({2100, 1900, 1000, 3000})));
  CHECK(right.shares == std::vector<double>({2000, 2000, 2000, 2000}));  // a tenth apart: both pairs are off
  const Plan one = policy->plan(table_of(loads_of({2010, 1990, 1000, 3000})));
  CHECK(one.shares == std::vector<double>({2010, 1990, 2000, 2000}));
}

TEST(cost_aware_moves_only_what_pays) {
  const auto made = [](double cost, double horizon) {
    return policy_made("CostAware", {{"move_cost", cost}, {"horizon", horizon}});
  };
  // Balance saves the time of 500 particles per frame, and each end gives or takes 500 particles.
  const LoadTable table = table_of(loads_of({1500, 500}));
  CHECK(made(10, 20)->plan(table).shares == std::vector<double>({1e6, 1e6}));
  CHECK(made(10, 9)->plan(table).empty());
  CHECK(made(0, 1)->plan(table_of(loads_of({1000, 1000}))).empty());
  // Slabs keep their order, so the calculators in the middle exchange all of their particles.
  const LoadTable chain = table_of(loads_of({3000, 1500, 1500, 0}));
  CHECK(!made(1, 20)->plan(chain).empty() && made(20, 1)->plan(chain).empty());
}

TEST(greedy_takes_from_the_slowest_until_neighbours_agree) {
  const auto policy = policy_made("Greedy");
  CHECK(policy->plan(table_of(loads_of({1000, 2000}))).orders == std::vector<Order>({{1, 0, 500}}));
  CHECK(policy->plan(table_of(loads_of({1000, 1010}))).orders.empty());
  CHECK(policy->plan(table_of(loads_of({100}))).empty());
  const std::vector<Load> crowd = loads_of({0, 0, 16000, 0, 0, 0, 0, 0});
  CHECK(after(*policy, crowd, 40) < 1.2);
  CHECK(after(*policy, half_fast(8, 10000), 40) < 1.2);
}

}  // namespace motes::test_balance_policies
