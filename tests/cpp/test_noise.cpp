// Curl noise: no divergence, smooth in space and time, of unit speed, the same bits in every build.
#include <cmath>
#include <cstring>
#include <vector>

#include "check.h"
#include "functions_builds.h"

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

// d v[component] / d axis by central differences, at every point.
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
