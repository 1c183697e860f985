// fluid: a step compared with all pairs in double precision.
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/check.h"
#include "support/crowds.h"
#include "support/isas.h"

namespace motes::test_fluid {
using test::Flock;
using test::Law;

namespace {

using Vec = std::array<double, 3>;

double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec triple(const Flock& flock, int first, std::size_t i) {
  Vec found;
  for (std::size_t c = 0; c < 3; ++c) found[c] = double{flock.column[static_cast<std::size_t>(first) + c][i]};
  return found;
}

// The formula of Fluid's docstring.
struct Liquid {
  const Flock& flock;
  const Law& law;
  const actions::numbers::fluid<> given = actions::numbers_of<actions::numbers::fluid>(law.action);
  double radius = double{law.reach}, rest = given.rest_density, step = double{law.step};
  double viscosity10 = 10 * (given.viscosity + radius * radius / step / 4000);

  double mass(std::size_t i) const { return double{flock.column[interactions::mass][i]}; }

  // A pair: distance, direction to the second, velocity of the second relative to the first.
  struct Pair {
    double distance;
    Vec normal, apart;
  };
  Pair pair(std::size_t i, std::size_t j) const {
    const Vec a = triple(flock, interactions::at_x, i), b = triple(flock, interactions::at_x, j);
    const Vec v = triple(flock, interactions::velocity_x, i), w = triple(flock, interactions::velocity_x, j);
    Pair made{std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]), {}, {}};
    for (std::size_t c = 0; c < 3; ++c) {
      made.normal[c] = (b[c] - a[c]) / made.distance;
      made.apart[c] = w[c] - v[c];
    }
    return made;
  }

  double spread(double r) const {
    return 315 / (64 * M_PI * std::pow(radius, 9)) * std::pow(radius * radius - r * r, 3);
  }
  double slope(double r) const { return 45 / (M_PI * std::pow(radius, 6)) * std::pow(radius - r, 2); }
  double bump(double r) const {  // Akinci et al. (2013)
    const double p = std::pow((radius - r) * r, 3);
    return 32 / (M_PI * std::pow(radius, 9)) * (2 * r > radius ? p : 2 * p - std::pow(radius, 6) / 64);
  }

  double pressure(std::size_t i) const {
    const double alone = mass(i) * spread(0);
    double density = alone, falls = 0, squares = 0;
    Vec gradient{};
    for (std::size_t j = 0; j < flock.size(); ++j) {
      if (j == i) continue;
      const Pair p = pair(i, j);
      if (p.distance >= radius) continue;
      density += mass(j) * spread(p.distance);
      falls += mass(j) * slope(p.distance) * dot(p.normal, p.apart);
      squares += mass(j) * std::pow(slope(p.distance), 2);
      for (std::size_t c = 0; c < 3; ++c) gradient[c] += mass(j) * slope(p.distance) * p.normal[c];
    }
    const double then = density / rest - std::max(alone / rest, 1.0), now = then + falls / rest * step;
    const double above = std::max(0.0, then - 0.95 * std::max(0.0, now));
    return above / ((dot(gradient, gradient) / mass(i) + squares) / (rest * rest));
  }

  Vec velocity(std::size_t i, const std::vector<double>& pressures, double& size) const {
    Vec sum = triple(flock, interactions::velocity_x, i);
    size = std::sqrt(dot(sum, sum));
    for (std::size_t j = 0; j < flock.size(); ++j) {
      if (j == i) continue;
      const Pair p = pair(i, j);
      if (p.distance >= radius) continue;
      const double push = (pressures[i] * mass(j) / mass(i) + pressures[j]) * slope(p.distance) / rest / step;
      const double rub = viscosity10 * dot(p.apart, p.normal) * slope(p.distance) / (p.distance + 0.1 * radius);
      const double pull = given.cohesion * bump(p.distance);
      const double all = (rub + pull) * mass(j) / rest * step - push;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += p.normal[c] * all;
      size += std::abs(all);
    }
    return sum;
  }
};

}  // namespace

TEST(liquids_come_to_all_pairs_in_double_precision) {
  const Flock flock = test::random_flock(1500, 1.0f, 21);
  for (const double rest : {100.0, 300.0, 1000.0}) {
    const Law law = test::fluid_law(0.25f, rest);
    const Liquid liquid{flock, law};
    std::vector<double> pressures;
    std::size_t dense = 0;
    for (std::size_t i = 0; i < flock.size(); ++i) {
      pressures.push_back(liquid.pressure(i));
      dense += pressures[i] > 0 ? 1 : 0;
    }
    CHECK(rest == 1000 ? dense < 500 : dense > 500);
    const test::Heard heard = test::heard(test::meeting_builds().back(), law, flock);
    for (std::size_t i = 0; i < flock.size(); ++i) {
      double size = 0;
      const Vec wanted = liquid.velocity(i, pressures, size);
      for (std::size_t c = 0; c < 3; ++c) CHECK_NEAR(double{heard.out[c][i]}, wanted[c], 2e-5 * size);
    }
  }
}

TEST(a_liquid_parts_those_at_one_place) {
  Flock flock = test::random_flock(40, 0.1f, 22);
  for (std::size_t c = 0; c < 6; ++c) std::fill(flock.column[c].begin(), flock.column[c].end(), 0.0f);
  const Law law = test::fluid_law(0.25f, 300, 0, 0);
  const test::Heard heard = test::heard(test::meeting_builds()[0], law, flock);
  Vec momentum{};
  for (std::size_t i = 0; i < flock.size(); ++i) {
    double speed = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      momentum[c] += double{heard.out[c][i]} * double{flock.column[interactions::mass][i]};
      speed += std::abs(double{heard.out[c][i]});
    }
    CHECK(std::isfinite(speed) && speed > 0);
  }
  for (const double component : momentum) CHECK_NEAR(component, 0, 1e-2);
}

}  // namespace motes::test_fluid
