// Sums over stores compared with plain loops.
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "particles/schema.h"
#include "program/sums.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_sums {
using actions::Op;
using program::Bins;
using program::Dimension;
using program::Sum;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const particles::Schema kSchema;

actions::Expression component(int attribute, int c = 0) {
  return {{Op::column, kSchema[attribute].first_component + c, 0}};
}

std::vector<double> regular_edges(double low, double high, int bins) {
  std::vector<double> edges;
  for (int i = 0; i <= bins; ++i) edges.push_back(low + (high - low) * i / bins);
  return edges;
}

// Returns the bin of numpy.histogram, by its definition.
std::uint32_t bin_of(const Dimension& dimension, float value) {
  const std::vector<double>& edges = dimension.edges;
  const auto bins = static_cast<std::uint32_t>(edges.size() - 1);
  for (std::uint32_t i = 0; i < bins; ++i) {
    if (edges[i] <= value && value < edges[i + 1]) return i;
  }
  return dimension.closed && value == edges.back() ? bins - 1 : bins;
}

void check_bins(const Dimension& dimension, test::Dice& dice) {
  const Bins bins(dimension);
  CHECK(bins.count() == dimension.edges.size() - 1);
  const auto check = [&](float value) { CHECK(bins.of(value) == bin_of(dimension, value)); };
  constexpr float kMost = std::numeric_limits<float>::infinity();
  for (const double edge : dimension.edges) {
    const auto near = static_cast<float>(edge);
    for (const float value : {near, std::nextafter(near, kMost), std::nextafter(near, -kMost)}) check(value);
  }
  for (const float value : {0.0f, -0.0f, kMost, -kMost, std::numeric_limits<float>::quiet_NaN()}) check(value);
  for (int i = 0; i < 50; ++i) check(dice.between(-3, 3));
}

particles::Store random_store(std::size_t count, test::Dice& dice) {
  particles::Store store(kSchema);
  store.grow(count);
  for (int c = 0; c < 3; ++c) {
    float* x = store.writable_plane(particles::position, c);
    for (std::size_t i = 0; i < count; ++i) x[i] = dice.between(-1.5f, 1.5f);
  }
  float* age = store.writable_plane(particles::age, 0);
  for (std::size_t i = 0; i < count; ++i) age[i] = std::ldexp(dice.between(-1, 1), static_cast<int>(dice.below(60)));
  return store;
}

Sum tally_of_test(bool weighted) {
  Sum sum;
  for (int c = 0; c < 3; ++c) {
    sum.dimensions.push_back({component(particles::position, c), regular_edges(-1, 1, 3 + c), false});
  }
  if (weighted) sum.weights = {component(particles::age)};
  sum.where = {{Op::column, kSchema[particles::position].first_component, 0}, {Op::constant, 0, 0.25f}, {Op::less}};
  return sum;
}

// Returns the expected result, by plain loops.
program::Summed plain_tally(const Sum& sum, const particles::Store& store, std::size_t count) {
  program::Summed summed = program::nothing(sum);
  for (std::size_t i = 0; i < count; ++i) {
    if (!(store.plane(particles::position, 0)[i] < 0.25f)) continue;
    std::size_t at = 0;
    bool inside = true;
    for (int c = 0; c < 3; ++c) {
      const Dimension& dimension = sum.dimensions[static_cast<std::size_t>(c)];
      const std::uint32_t bin = bin_of(dimension, store.plane(particles::position, c)[i]);
      inside = inside && bin < dimension.edges.size() - 1;
      at = at * (dimension.edges.size() - 1) + bin;
    }
    if (!inside) continue;
    if (auto* counts = std::get_if<0>(&summed)) ++(*counts)[at];
    if (auto* sums = std::get_if<1>(&summed)) (*sums)[at].add(store.plane(particles::age, 0)[i]);
  }
  return summed;
}

program::Summed doubled(program::Summed summed) {
  const program::Summed once = summed;
  std::visit(
      [&](auto& results) {
        for (std::size_t i = 0; i < results.size(); ++i)
          results[i] += std::get<std::decay_t<decltype(results)>>(once)[i];
      },
      summed);
  return summed;
}

}  // namespace

TEST(bins_hold_what_numpy_puts_into_them) {
  test::Dice dice(5);
  for (const bool closed : {false, true}) {
    for (int trial = 0; trial < 200; ++trial) {
      std::vector<double> edges{dice.between(-2, 0)};
      const std::size_t count = 1 + dice.below(20);
      while (edges.size() <= count) edges.push_back(edges.back() + static_cast<double>(dice.between(1e-7f, 0.3f)));
      check_bins({{}, edges, closed}, dice);
      check_bins({{}, regular_edges(edges.front(), edges.back(), static_cast<int>(count)), closed}, dice);
      edges.front() = -kInfinity;
      edges.back() = kInfinity;
      check_bins({{}, edges, closed}, dice);
    }
    check_bins({{}, {0, 1e300}, closed}, dice);
    check_bins({{}, {-1e300, 1, 1 + 1e-12, 2}, closed}, dice);  // no float32 is in the third bin but 1 in the second
    check_bins({{}, {0, 0x1p-149, 0x1p-148}, closed}, dice);
  }
}

TEST(tallies_are_those_of_plain_loops_on_any_threads) {
  test::Dice dice(6);
  for (const std::size_t count : {0, 1, 127, 5000}) {
    particles::Store store = random_store(count + 3, dice);
    for (const bool weighted : {false, true}) {
      const Sum sum = tally_of_test(weighted);
      const program::Summed wanted = plain_tally(sum, store, count);
      CHECK(count < 5000 || !(wanted == program::nothing(sum)));
      for (const int threads : {1, 2, 3}) {
        threads::Pool pool(threads, threads == 1 ? SIZE_MAX : 300);
        CHECK(program::sum_up(sum, store, count, pool) == wanted);
      }
    }
  }
}

TEST(totals_leave_out_what_stands_behind_the_particles_that_are_seen) {
  test::Dice dice(7);
  particles::Store store = random_store(3000, dice);
  Sum sum;
  sum.weights = {component(particles::age), {{Op::constant, 0, 2}}};
  for (const int threads : {1, 3}) {
    threads::Pool pool(threads, threads == 1 ? SIZE_MAX : 200);
    particles::ExactSum wanted;
    for (std::size_t i = 0; i < 2500; ++i) wanted.add(store.plane(particles::age, 0)[i]);
    const auto found = std::get<std::vector<double>>(program::totals(program::sum_up(sum, store, 2500, pool)));
    CHECK(found == (std::vector<double>{wanted.rounded(), 5000}));
  }
}

TEST(sums_as_bytes_leave_out_zeros_and_do_not_fit_other_bins) {
  test::Dice dice(8);
  particles::Store store = random_store(40, dice);
  for (const bool weighted : {false, true}) {
    const Sum sum = tally_of_test(weighted);
    const program::Summed once = program::sum_up(sum, store, 40);
    program::Summed twice = once;
    base::Bytes bytes;
    program::write(once, bytes);
    CHECK(bytes.size() <= 16 + 40 * (weighted ? 48 : 8));  // of 60 bins fewer than 40 hold a particle
    base::Reader in(bytes.view());
    program::add(in, twice);
    CHECK(in.done() && twice == doubled(plain_tally(sum, store, 40)));
    Sum other = sum;
    other.dimensions.pop_back();
    program::Summed fewer = program::nothing(other);
    base::Reader again(bytes.view());
    CHECK_THROWS(program::add(again, fewer), std::runtime_error);
  }
}

TEST(sums_that_make_no_sense_are_refused) {
  Sum good = tally_of_test(true);
  program::check(good, kSchema);
  const auto refused = [&](auto change) {
    Sum sum = good;
    change(sum);
    CHECK_THROWS(program::check(sum, kSchema), std::invalid_argument);
  };
  refused([](Sum& s) { s.dimensions[0].edges = {1}; });
  refused([](Sum& s) { s.dimensions[0].edges = {1, 1}; });
  refused([](Sum& s) { s.dimensions[0].edges = {0, std::nan(""), 1}; });
  refused([](Sum& s) { s.dimensions[0].edges = regular_edges(0, 1, 1 << 22); });  // times 4 times 5
  refused([](Sum& s) { s.dimensions[0].value = s.where; });
  refused([](Sum& s) { s.weights.push_back(s.weights[0]); });
  refused([](Sum& s) { s.weights[0][0].index = 1000; });
  refused([](Sum& s) { s.where = s.weights[0]; });
  refused([](Sum& s) { s = {}; });
}

}  // namespace motes::test_sums
