#include "interactions/extent.h"

#include <algorithm>
#include <cmath>

#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using actions::Action;
using particles::Store;

template <class Work>
void each_range(std::size_t count, threads::Pool& pool, std::vector<float>& most, const Work& work) {
  const std::size_t range = pool.items(kRange);
  most.assign((count + range - 1) / range, 0);
  pool.run(most.size(), [&](std::size_t part, std::size_t) {
    const simd::FloatMode mode;
    work(part * range, std::min(count, (part + 1) * range), most[part]);
  });
}

float largest(const std::vector<float>& values) {
  float most = 0;
  for (const float value : values) most = std::max(most, value);
  return most;
}

// Returns the largest displacement along an axis in the step, m, ignoring obstacles and particles at NaN.
float displacement_of(const Store& store, float dt, threads::Pool& pool) {
  std::vector<float> most;
  each_range(store.size(), pool, most, [&](std::size_t first, std::size_t last, float& far) {
    for (int c = 0; c < 3; ++c) {
      const float* x = store.plane(particles::position, c);
      const float* v = store.plane(particles::velocity, c);
      const float same_x = store.uniform_value(particles::position)[static_cast<std::size_t>(c)];
      const float same_v = store.uniform_value(particles::velocity)[static_cast<std::size_t>(c)];
      for (std::size_t i = first; i < last; ++i) {
        const float from = x != nullptr ? x[i] : same_x;
        const float way = std::abs((from + (v != nullptr ? v[i] : same_v) * dt) - from);
        if (way > far) far = way;
      }
    }
  });
  return largest(most);
}

float radius_of(const Store& store, threads::Pool& pool) {
  const float* size = store.plane(particles::size, 0);
  if (size == nullptr) return store.size() == 0 ? 0 : std::max(0.0f, 0.5f * store.uniform_value(particles::size)[0]);
  std::vector<float> most;
  each_range(store.size(), pool, most, [&](std::size_t first, std::size_t last, float& wide) {
    for (std::size_t i = first; i < last; ++i) {
      if (0.5f * size[i] > wide) wide = 0.5f * size[i];
    }
  });
  return largest(most);
}

// Returns the largest 1 / mass, 1/kg, ignoring massless particles; 0 if all masses are 1 kg.
float lightness_of(const Store& store, threads::Pool& pool) {
  constexpr float kNobody = 0x1p-126f;  // above 0, but below any real 1 / mass
  const auto lightness = [](float mass) { return mass >= kLeastMass ? 1 / mass : kNobody; };
  if (store.size() == 0) return 0;
  const float* mass = store.plane(particles::mass, 0);
  const float same = store.uniform_value(particles::mass)[0];
  if (mass == nullptr) return same == 1 ? 0 : lightness(same);
  std::vector<float> most;
  each_range(store.size(), pool, most, [&](std::size_t first, std::size_t last, float& light) {
    for (std::size_t i = first; i < last; ++i) {
      const float of_one = lightness(mass[i]);
      if (of_one > light) light = of_one;
    }
  });
  return largest(most);
}

}  // namespace

const Law& law_of(const Action& action) { return kernels().law[static_cast<std::size_t>(action.kind)]; }

bool remembers(const Action& action) { return law_of(action).remembers; }

bool has_radius(const Action& action) { return law_of(action).radius != nullptr; }

float given_radius(const Action& action, bool second) { return law_of(action).radius(action.numbers.data(), second); }

std::vector<Component> components_of(std::uint32_t attributes) {
  std::vector<Component> all;
  for (int attribute = 0; attribute < particles::builtin_count; ++attribute) {
    if ((attributes >> attribute & 1u) == 0) continue;
    const int width =
        attribute == particles::size ? 1 : particles::kBuiltins[static_cast<std::size_t>(attribute)].width;
    for (int c = 0; c < width; ++c) all.push_back({attribute, c});
  }
  return all;
}

std::vector<Component> read_by(const Action& action) { return components_of(actions::facts(action.kind).reads); }

std::vector<Component> changed_by(const Action& action) { return components_of(actions::facts(action.kind).writes); }

void Extent::widen(const Extent& other) {
  radius = std::max(radius, other.radius);
  other_radius = std::max(other_radius, other.other_radius);
  displacement = std::max(displacement, other.displacement);
  masses = std::max(masses, other.masses);
}

Extent extent_of(const Action& action, const Store& store, float dt, bool second, threads::Pool& pool) {
  Extent extent;
  const simd::FloatMode mode;
  if (has_radius(action)) {
    const float given = given_radius(action, second);
    float& radius = second ? extent.other_radius : extent.radius;
    radius = given > 0 ? given : radius_of(store, pool);
  }
  if (law_of(action).looks_ahead) extent.displacement = displacement_of(store, dt, pool);
  if (law_of(action).inverse_masses) extent.masses = lightness_of(store, pool);
  return extent;
}

float reach_of(const Action& action, const Extent& extent) {
  const Law& law = law_of(action);
  if (law.reach != nullptr) return law.reach(action.numbers.data());
  return extent.radius + (action.partner ? extent.other_radius : extent.radius);
}

double range_of(const Action& action, const Extent& extent) {
  const double reach = static_cast<double>(reach_of(action, extent));
  const Law& law = law_of(action);
  // If a law prepares, sources need all of their own neighbours, too.
  const double seen = law.prepare != nullptr ? 2 * reach : reach;
  if (!law.looks_ahead) return seen * (1 + 4 * kMargin);
  const double step =
      std::min(static_cast<double>(extent.displacement), static_cast<double>(step_limit(reach_of(action, extent))));
  return (seen + 2 * (step + static_cast<double>(extent.rounding))) * (1 + 4 * kMargin);
}

}  // namespace motes::interactions
