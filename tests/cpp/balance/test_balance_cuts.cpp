// Where donors cut, how particles are counted into bins, and cuts from the bins of all calculators.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>

#include "balance/cuts.h"
#include "support/check.h"

namespace motes::test_balance_cuts {
using namespace balance;

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

std::uint64_t below(const std::vector<float>& xs, float cut) {
  return static_cast<std::uint64_t>(std::count_if(xs.begin(), xs.end(), [&](float x) { return x < cut; }));
}

std::uint64_t from(const std::vector<float>& xs, float cut) {
  return static_cast<std::uint64_t>(std::count_if(xs.begin(), xs.end(), [&](float x) { return x >= cut; }));
}

float uniform(std::mt19937_64& random) { return static_cast<float>(random() % (1 << 24)) * 0x1p-24f; }

// Returns coordinates in one of several distributions.
std::vector<float> spread(int kind, std::size_t count, std::mt19937_64& random) {
  std::vector<float> xs(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float u = uniform(random);
    if (kind == 0) xs[i] = u;  // evenly
    if (kind == 1) xs[i] = std::floor(u * 8);  // at eight places
    if (kind == 2) xs[i] = u < 0.5f ? u : 1e6f + u;  // two far clusters
    if (kind == 3) xs[i] = u * u * u * u * u * u;  // mostly at one end
    if (kind == 4) xs[i] = 3;  // all at one place
    if (kind == 5) xs[i] = static_cast<float>(i) / static_cast<float>(count);  // in order
  }
  return xs;
}

double total(const Histogram& h) {
  return static_cast<double>(std::accumulate(h.counts.begin(), h.counts.end(), std::uint64_t{0}));
}

bool alike(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) { return std::abs(x - y) < 1e-6f; });
}

}  // namespace

TEST(gifts_are_exact_where_particles_differ) {
  std::mt19937_64 random(1);
  for (const int kind : {0, 2, 5}) {
    std::vector<float> xs = spread(kind, 5000, random);
    std::sort(xs.begin(), xs.end());
    xs.erase(std::unique(xs.begin(), xs.end()), xs.end());
    std::shuffle(xs.begin(), xs.end(), random);
    for (const std::uint64_t wanted : {1u, 2u, 17u, 1000u, 2500u, 4000u, 4900u}) {
      if (wanted > xs.size()) continue;
      const Gift left = give_left(xs, wanted, -1, 2e6f);
      CHECK(left.count == wanted && below(xs, left.cut) == wanted);
      const Gift right = give_right(xs, wanted, -1, 2e6f);
      CHECK(right.count == wanted && from(xs, right.cut) == wanted);
    }
  }
}

TEST(gifts_never_exceed_the_order_and_miss_only_ties) {
  std::mt19937_64 random(2);
  for (int kind = 0; kind < 6; ++kind) {
    for (const std::size_t n : {1u, 2u, 3u, 100u, 3000u}) {
      const std::vector<float> xs = spread(kind, n, random);
      for (int round = 0; round < 20; ++round) {
        const std::uint64_t wanted = random() % (n + 2);
        const Gift left = give_left(xs, wanted, -1, 2e6f);
        CHECK(left.count <= wanted && below(xs, left.cut) == left.count);
        const Gift right = give_right(xs, wanted, -1, 2e6f);
        CHECK(right.count <= wanted && from(xs, right.cut) == right.count);
        // A cut at the next coordinate would give too many.
        float next = inf;
        float previous = -inf;
        for (const float x : xs) {
          if (x >= left.cut) next = std::min(next, x);
          if (x < right.cut) previous = std::max(previous, x);
        }
        if (next < inf) CHECK(below(xs, std::nextafter(next, inf)) > wanted);
        if (previous > -inf) CHECK(from(xs, previous) > wanted);
        // Gifts to both sides do not cross.
        if (wanted <= n) CHECK(give_left(xs, n - wanted, -1, 2e6f).cut <= right.cut);
      }
    }
  }
}

TEST(gifts_of_everything_and_of_nothing) {
  const std::vector<float> xs{5, 1, 3};
  CHECK(give_left(xs, 0, 0, 9).cut == 0 && give_left(xs, 0, 0, 9).count == 0);
  CHECK(give_right(xs, 0, 0, 9).cut == 9 && give_right(xs, 0, 0, 9).count == 0);
  CHECK(give_left(xs, 3, 0, 9).cut == std::nextafter(5.0f, inf) && give_left(xs, 99, 0, 9).count == 3);
  CHECK(give_right(xs, 3, 0, 9).cut == 1 && give_right(xs, 99, 0, 9).count == 3);
  CHECK(give_left({}, 5, 0, 9).count == 0 && give_right({}, 5, 0, 9).cut == 9);
  const std::vector<float> same(100, 2.0f);
  CHECK(give_left(same, 99, 0, 9).count == 0 && give_left(same, 99, 0, 9).cut == 0);
  CHECK(give_right(same, 99, 0, 9).count == 0 && give_right(same, 99, 0, 9).cut == 9);
  CHECK(give_right(same, 100, 0, 9).count == 100);
}

TEST(what_is_no_number_stays) {
  const std::vector<float> xs{not_a_number, 1, inf, 2, not_a_number, 3};
  CHECK(give_left(xs, 2, 0, inf).count == 2 && give_left(xs, 2, 0, inf).cut == 3);
  CHECK(give_left(xs, 6, 0, inf).count == 3);
  CHECK(give_left(std::vector<float>(9, not_a_number), 5, 0, inf).count == 0);
  const std::vector<float> first{-inf, -5, -4};
  CHECK(give_right(first, 1, -inf, 0).cut == -4 && give_right(first, 2, -inf, 0).count == 2);
  const Histogram h = histogram(std::vector<float>{not_a_number, 1, inf, 2, -inf, 3}, 4);
  CHECK(total(h) == 3 && h.edges.front() == 1 && h.edges.back() == 3);
  CHECK(histogram(std::vector<float>{not_a_number, inf}, 4).edges.empty());
  CHECK(quantiles(std::vector<float>{not_a_number, inf}, 4).empty());
}

TEST(histograms_count_all_in_bins_of_about_equal_counts) {
  std::mt19937_64 random(4);
  for (int kind = 0; kind < 6; ++kind) {
    for (const int bins : {1, 2, 7, 64, 100}) {
      const std::vector<float> xs = spread(kind, 20000, random);
      const Histogram h = histogram(xs, bins);
      CHECK(h.edges.size() == h.counts.size() + 1 && h.counts.size() <= static_cast<std::size_t>(bins));
      CHECK(std::is_sorted(h.edges.begin(), h.edges.end()));
      CHECK(total(h) == 20000);
      for (std::size_t i = 0; i + 1 < h.counts.size(); ++i) {
        CHECK(below(xs, h.edges[i + 1]) - below(xs, h.edges[i]) == h.counts[i]);
        const bool one_place = std::nextafter(h.edges[i], inf) == h.edges[i + 1];
        if (kind != 1 && !one_place) CHECK(static_cast<double>(h.counts[i]) < 2.5 * 20000 / bins + 1);
      }
    }
  }
  // A coordinate that many particles share has its own bin.
  std::vector<float> xs = spread(0, 1000, random);
  xs.insert(xs.end(), 1000, 0.25f);
  const Histogram h = histogram(xs, 16);
  const auto at = std::find(h.edges.begin(), h.edges.end(), 0.25f);
  CHECK(at != h.edges.end() && *(at + 1) == std::nextafter(0.25f, inf));
}

TEST(quantiles_divide_evenly) {
  std::mt19937_64 random(5);
  const std::vector<float> q = quantiles(spread(0, 100000, random), 16);
  CHECK(q.size() == 17 && std::is_sorted(q.begin(), q.end()));
  for (std::size_t i = 0; i <= 16; ++i) CHECK_NEAR(q[i], static_cast<double>(i) / 16, 0.08);
  CHECK(quantiles(std::vector<float>{7}, 4) == std::vector<float>(5, 7.0f));
  CHECK(quantiles(std::vector<float>{1, 2, 3, 4, 5}, 4) == std::vector<float>({1, 2, 3, 4, 5}));
}

TEST(prefix_cuts_are_exact_on_what_is_spread_evenly) {
  const Histogram whole{{0, 1, 2, 3, 4}, {100, 100, 100, 100}};
  const std::vector<Histogram> one{whole, {}, {}, {}};
  const std::vector<float> before{10, 20, 30};
  CHECK(prefix_cuts(one, {}, std::vector<double>{1, 1, 1, 1}, before) == std::vector<float>({1, 2, 3}));
  CHECK(alike(prefix_cuts(one, {}, std::vector<double>{1, 2, 4, 1}, before), {0.5, 1.5, 3.5}));
  // The cost depends on the position: the second half costs three times as much.
  const std::vector<Histogram> two{{{0, 2}, {100}}, {{2, 4}, {100}}};
  CHECK(prefix_cuts(two, std::vector<double>{1, 3}, std::vector<double>{1, 1}, std::vector<float>{2}) ==
        std::vector<float>({2 + 2.0f / 3}));
  // Histograms may overlap, as they do while particles wait for their owner.
  const std::vector<Histogram> over{{{0, 4}, {100}}, {{0, 2}, {100}}, {}};
  CHECK(alike(prefix_cuts(over, {}, std::vector<double>{3, 3, 2}, std::vector<float>{1, 2}), {1, 2}));
}

TEST(prefix_cuts_leave_cuts_in_gaps_where_they_are) {
  const std::vector<Histogram> gap{{{0, 1}, {50}}, {{8, 9}, {50}}};
  const std::vector<double> even{1, 1};
  CHECK(prefix_cuts(gap, {}, even, std::vector<float>{5})[0] == 5);
  CHECK(prefix_cuts(gap, {}, even, std::vector<float>{20})[0] == 8);
  CHECK(prefix_cuts(gap, {}, even, std::vector<float>{-3})[0] == std::nextafter(1.0f, inf));
  // Calculators without a share get an empty domain; at the ends it is wide.
  const std::vector<Histogram> three{{{0, 1}, {50}}, {{8, 9}, {50}}, {}};
  CHECK(prefix_cuts(three, {}, std::vector<double>{0, 1, 0}, std::vector<float>{-5, 20}) ==
        std::vector<float>({-5, 20}));
  CHECK(prefix_cuts(three, {}, std::vector<double>{1, 0, 1}, std::vector<float>{3, 4}) == std::vector<float>({3, 4}));
  const std::vector<float> before{3, 4};
  CHECK(prefix_cuts(std::vector<Histogram>(3), {}, std::vector<double>{1, 1, 1}, before) == before);
  CHECK(prefix_cuts(std::vector<Histogram>(1), {}, std::vector<double>{1}, {}).empty());
  const std::vector<double> too_many{1, 1, 1};
  CHECK_THROWS(prefix_cuts(gap, {}, too_many, before), std::invalid_argument);
}

TEST(prefix_cuts_cannot_part_what_is_at_one_place) {
  const std::vector<Histogram> point{histogram(std::vector<float>(100, 5.0f), 8), {}, {}};
  const std::vector<float> cuts = prefix_cuts(point, {}, std::vector<double>{1, 1, 1}, std::vector<float>{0, 1});
  CHECK(cuts == std::vector<float>({5, std::nextafter(5.0f, inf)}));  // everything to the one in the middle
}

TEST(prefix_cuts_divide_particles_within_a_bin) {
  std::mt19937_64 random(6);
  for (int kind = 0; kind < 6; ++kind) {
    const std::size_t calculators = 2 + random() % 12;
    std::vector<Histogram> histograms;
    std::vector<float> all;
    std::vector<double> shares;
    double bin = 0;
    for (std::size_t c = 0; c < calculators; ++c) {
      std::vector<float> xs = spread(kind, random() % 5000, random);
      for (float& x : xs) x += kind % 2 == 0 ? 0 : 2e6f * static_cast<float>(c);  // overlapping, or not
      histograms.push_back(histogram(xs, 32));
      for (const std::uint64_t n : histograms.back().counts) bin = std::max(bin, static_cast<double>(n));
      all.insert(all.end(), xs.begin(), xs.end());
      shares.push_back(static_cast<double>(random() % 4));
    }
    shares[0] += 1;
    const double parts = std::accumulate(shares.begin(), shares.end(), 0.0);
    const std::vector<float> cuts = prefix_cuts(histograms, {}, shares, std::vector<float>(calculators - 1, 0.0f));
    CHECK(std::is_sorted(cuts.begin(), cuts.end()));
    double part = 0;
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      part += shares[i];
      const double ideal = static_cast<double>(all.size()) * part / parts;
      const double slack = kind % 2 == 0 ? bin * static_cast<double>(calculators) : bin;
      CHECK_NEAR(static_cast<double>(below(all, cuts[i])), ideal, slack + 1);
    }
  }
}

}  // namespace motes::test_balance_cuts
