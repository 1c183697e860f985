// Curl noise: no divergence, smooth in space and time, of unit speed, the same bits in every build. Noise of a point.
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "support/check.h"
#include "support/functions_builds.h"

namespace motes::test_noise {
namespace {

struct Points {
  std::vector<float> plane[3];
  explicit Points(std::size_t count) {
    for (auto& p : plane) p.resize(count);
  }
  std::size_t size() const { return plane[0].size(); }
  const float* const* in() const {
    static thread_local const float* planes[3];
    for (int c = 0; c < 3; ++c) planes[c] = plane[c].data();
    return planes;
  }
};

Points scattered(std::size_t count, float size) {
  test::Dice dice(21);
  Points p(count);
  for (auto& plane : p.plane) {
    for (float& v : plane) v = dice.between(-size, size);
  }
  return p;
}

Points curl(const test::FunctionsProbe& build, const Points& p, int octaves, double time, std::uint32_t seed = 5) {
  Points v(p.size());
  float* out[3] = {v.plane[0].data(), v.plane[1].data(), v.plane[2].data()};
  build.curl(p.in(), p.size(), octaves, time, seed, out);
  return v;
}

constexpr std::size_t kMany = 1 << 16;

// Returns d v[component] / d axis by central differences, at every point.
std::vector<double> slope(const Points& p, int octaves, double time, int component, int axis, float step) {
  const test::FunctionsProbe& build = *test::function_builds().back();
  Points ahead = p, behind = p;
  for (std::size_t i = 0; i < p.size(); ++i) {
    ahead.plane[axis][i] += step;
    behind.plane[axis][i] -= step;
  }
  const Points a = curl(build, ahead, octaves, time), b = curl(build, behind, octaves, time);
  std::vector<double> found(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double width = double{ahead.plane[axis][i]} - behind.plane[axis][i];
    found[i] = (double{a.plane[component][i]} - b.plane[component][i]) / width;
  }
  return found;
}

double root_mean_square(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum / static_cast<double>(v.size()));
}

double speed(const Points& v) {
  std::vector<double> all;
  for (std::size_t i = 0; i < v.size(); ++i) {
    all.push_back(std::sqrt(double{v.plane[0][i]} * v.plane[0][i] + double{v.plane[1][i]} * v.plane[1][i] +
                            double{v.plane[2][i]} * v.plane[2][i]));
  }
  return root_mean_square(all);
}

}  // namespace

TEST(curl_noise_has_no_divergence) {
  for (const int octaves : {1, 3}) {
    for (const double time : {0.0, 2.3}) {
      const Points p = scattered(kMany, 4);
      const float step = 1.0f / 256 / static_cast<float>(1 << (octaves - 1));
      std::vector<double> divergence(p.size()), gradient;
      for (int component = 0; component < 3; ++component) {
        for (int axis = 0; axis < 3; ++axis) {
          const std::vector<double> d = slope(p, octaves, time, component, axis, step);
          gradient.insert(gradient.end(), d.begin(), d.end());
          for (std::size_t i = 0; axis == component && i < p.size(); ++i) divergence[i] += d[i];
        }
      }
      const double size = root_mean_square(gradient) * 3;  // of the whole 3 x 3 matrix
      CHECK(root_mean_square(divergence) < 1e-3 * size);
      CHECK(size > 1);
    }
  }
}

TEST(curl_noise_has_unit_speed_at_any_time) {
  const test::FunctionsProbe& build = *test::function_builds().back();
  const Points p = scattered(kMany, 1000);
  for (const double time : {-7.0, 0.0, 0.25, 0.5, 1e6}) {
    const Points v = curl(build, p, 1, time);
    CHECK_NEAR(speed(v), 1, 0.02);
    for (const auto& plane : v.plane) {
      double mean = 0;
      for (const float x : plane) mean += x / static_cast<double>(kMany);
      CHECK_NEAR(mean, 0, 0.02);
    }
  }
}

TEST(curl_noise_is_smooth) {
  const test::FunctionsProbe& build = *test::function_builds().back();
  Points p(kMany);  // along a line through many cells
  for (std::size_t i = 0; i < kMany; ++i) {
    p.plane[0][i] = static_cast<float>(i) / 4096 - 8;
    p.plane[1][i] = 0.3f;
    p.plane[2][i] = static_cast<float>(i) / 8192 - 3;
  }
  const Points v = curl(build, p, 1, 0.4);
  double jump = 0, kink = 0;
  for (std::size_t i = 1; i + 1 < kMany; ++i) {
    for (const auto& plane : v.plane) {
      jump = std::fmax(jump, std::fabs(double{plane[i + 1]} - plane[i]));
      kink = std::fmax(kink, std::fabs(double{plane[i + 1]} - 2 * double{plane[i]} + plane[i - 1]));
    }
  }
  CHECK(jump < 12.0 / 4096);  // a bounded first derivative
  CHECK(kink < 250.0 / 4096 / 4096);  // a bounded second derivative: a jump of the first by 0.06 would show
  const Points now = curl(build, p, 2, 2.9999), then = curl(build, p, 2, 3.0001);
  for (std::size_t i = 0; i < kMany; ++i) CHECK_NEAR(now.plane[0][i], then.plane[0][i], 1e-5);
}

TEST(curl_noise_depends_on_key_and_time_alone) {
  const Points p = scattered(1 << 12, 50);
  const auto builds = test::function_builds();
  const Points first = curl(*builds[0], p, 4, 1.75);
  for (const auto* build : builds) {
    const Points other = curl(*build, p, 4, 1.75);
    for (int c = 0; c < 3; ++c) {
      CHECK(std::memcmp(first.plane[c].data(), other.plane[c].data(), p.size() * sizeof(float)) == 0);
    }
  }
  for (const Points& other : {curl(*builds[0], p, 4, 1.75, 6), curl(*builds[0], p, 4, 4)}) {
    double product = 0, square = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      product += double{first.plane[0][i]} * other.plane[0][i];
      square += double{first.plane[0][i]} * first.plane[0][i];
    }
    CHECK(std::fabs(product) < 0.1 * square);  // a different field, not a shifted view of the same one
  }
  const float strange[] = {__builtin_nanf(""), __builtin_inff(), -3e38f, 1e9f};
  Points far(16);
  for (std::size_t i = 0; i < 16; ++i) far.plane[i % 3][i] = strange[i % 4];
  const Points v = curl(*builds.back(), far, 2, 0.5);
  for (const auto& plane : v.plane) {
    for (const float x : plane) CHECK(std::isfinite(x));
  }
}

namespace {

struct Events {
  std::vector<float> plane[4];  // x, y, z, time
  const float* in[4];
};

Events events(std::size_t count, float size, bool moving) {
  test::Dice dice(22);
  Events e;
  for (int c = 0; c < 4; ++c) {
    e.plane[c].resize(count);
    for (float& v : e.plane[c]) v = c < 3 || moving ? dice.between(-size, size) : 0;
    e.in[c] = e.plane[c].data();
  }
  return e;
}

std::vector<float> noise(const test::FunctionsProbe& build, const Events& e, int octaves, std::uint32_t field = 0) {
  std::vector<float> out(e.plane[0].size());
  build.noise(e.in, out.size(), octaves, field, out.data());
  return out;
}

double root_mean_square(const std::vector<float>& v) {
  return root_mean_square(std::vector<double>(v.begin(), v.end()));
}

}  // namespace

TEST(noise_has_a_root_mean_square_of_a_third) {
  for (const int octaves : {1, 4}) {
    for (const bool moving : {false, true}) {
      const std::vector<float> v = noise(*test::function_builds().back(), events(kMany, 100, moving), octaves);
      CHECK_NEAR(root_mean_square(v), 1.0 / 3, 0.004);
      double sum = 0;
      for (const float x : v) sum += x;
      CHECK_NEAR(sum / static_cast<double>(kMany), 0, 0.01);
    }
  }
}

TEST(noise_is_smooth_in_space_and_time) {
  const test::FunctionsProbe& build = *test::function_builds().back();
  const Events e = events(kMany, 20, true);
  const std::vector<float> here = noise(build, e, 1);
  for (int axis = 0; axis < 4; ++axis) {
    Events there = events(kMany, 20, true);
    for (float& v : there.plane[axis]) v += 1.0f / 1024;
    const std::vector<float> moved = noise(build, there, 1);
    float most = 0;
    for (std::size_t i = 0; i < kMany; ++i) most = std::max(most, std::fabs(moved[i] - here[i]));
    CHECK(most > 1e-4f && most < 6.0f / 1024);  // the steepest slope of a blend of a few units per cell
  }
}

TEST(noise_has_independent_fields_and_the_same_bits_in_every_build) {
  const Events still = events(4096, 20, false), e = events(4096, 20, true);
  const auto& builds = test::function_builds();
  for (const Events* points : {&still, &e}) {
    const std::vector<float> first = noise(*builds.front(), *points, 3, 7);
    for (const test::FunctionsProbe* build : builds) {
      const std::vector<float> other = noise(*build, *points, 3, 7);
      CHECK(std::memcmp(first.data(), other.data(), first.size() * sizeof(float)) == 0);
    }
    const std::vector<float> field = noise(*builds.front(), *points, 3, 8);
    double both = 0;
    for (std::size_t i = 0; i < first.size(); ++i) both += double{first[i]} * field[i];
    CHECK_NEAR(both / 4096 * 9, 0, 0.1);  // the correlation
  }
  // A particle at rest in time has the same bits beside one that moves.
  Events mixed = events(16, 20, true);
  const Events alone = events(16, 20, false);
  for (std::size_t i = 0; i < 16; i += 2) {
    for (int c = 0; c < 4; ++c) mixed.plane[c][i] = alone.plane[c][i];
  }
  const std::vector<float> a = noise(*builds.back(), alone, 2), b = noise(*builds.back(), mixed, 2);
  for (std::size_t i = 0; i < 16; i += 2)
    CHECK(std::bit_cast<std::uint32_t>(a[i]) == std::bit_cast<std::uint32_t>(b[i]));
}

TEST(noise_of_what_is_not_finite_is_nan) {
  for (int c = 0; c < 4; ++c) {
    for (const float wrong : {NAN, INFINITY}) {
      Events e = events(16, 2, true);
      e.plane[c][3] = wrong;
      const std::vector<float> v = noise(*test::function_builds().back(), e, 1);
      for (std::size_t i = 0; i < 16; ++i) CHECK(std::isnan(v[i]) == (i == 3));
    }
  }
}

}  // namespace motes::test_noise
