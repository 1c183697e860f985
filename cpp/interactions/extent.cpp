#include "interactions/extent.h"

#include <algorithm>
#include <cmath>

#include "interactions/clumps.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using actions::Action;
using actions::Kind;
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

// Lists the components of attributes. Only the first component of size, a sphere's diameter, counts.
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

}  // namespace

const Law& law_of(const Action& action) { return kernels().law[static_cast<std::size_t>(action.kind)]; }

bool remembers(const Action& action) { return law_of(action).remembers || action.kind == Kind::interact; }

bool has_radius(const Action& action) { return law_of(action).radius != nullptr; }

float given_radius(const Action& action, bool second) { return law_of(action).radius(action.numbers.data(), second); }

std::vector<Component> read_by(const Action& action, bool second) {
  if (action.kind != Kind::interact) return components_of(actions::facts(action.kind).reads);
  std::vector<Component> read;
  if (action.partner && !second) return read;  // only the other system's particles are sources
  read = components_of(actions::facts(action.kind).reads);
  for (const actions::Leaf& leaf : std::get<actions::PairLaw>(action.specifics).leaves) {
    const Component one{leaf.attribute, leaf.component};
    if (leaf.of == actions::Leaf::Of::other && std::find(read.begin(), read.end(), one) == read.end()) {
      read.push_back(one);
    }
  }
  return read;
}

std::vector<Component> changed_by(const Action& action) { return components_of(actions::facts(action.kind).writes); }

Extent extent_of(const Action& action, const Store& store, float dt, bool second, threads::Pool& pool) {
  Extent extent;
  const simd::FloatMode mode;
  if (has_radius(action)) {
    const float given = given_radius(action, second);
    float& radius = second ? extent.other_radius : extent.radius;
    radius = given > 0 ? given : radius_of(store, pool);
    if (action.kind == Kind::contact_clumps)
      radius *= 2 * bounding_radius(spheres_of(actions::grains_of(action)->clump));  // so far, half of the size
  }
  if (law_of(action).looks_ahead) extent.displacement = displacement_of(store, dt, pool);
  if (law_of(action).inverse_masses) extent.masses = lightness_of(store, pool);
  return extent;
}

float reach_of(const Action& action, const Extent& extent) {
  const Law& law = law_of(action);
  if (action.kind == Kind::tie) return extent.radius + 2 * extent.displacement;
  if (law.reach != nullptr) return law.reach(action.numbers.data());
  return extent.radius + (action.partner ? extent.other_radius : extent.radius);
}

float substeps(const Action& action, const Extent& extent, double frame_s) {
  const actions::Grains* const grains = actions::grains_of(action);
  if (grains == nullptr) return 0;
  double lightness = extent.masses > 0 ? static_cast<double>(extent.masses) : 1;
  if (action.kind == Kind::contact_clumps)
    lightness *= actions::numbers_of<actions::numbers::contact_clumps>(action).lightness;
  double stiffest = 2 * actions::contact_of(action).stiffness;  // for half of the mass
  for (const actions::WallNumbers& wall : grains->walls) stiffest = std::max(stiffest, wall.stiffness);
  return static_cast<float>(std::ceil(frame_s * std::sqrt(lightness * (stiffest / double{kMostStiff}))));
}

double range_of(const Action& action, const Extent& extent) {
  const double reach = static_cast<double>(reach_of(action, extent));
  if (action.kind == Kind::tie) return reach * (1 + 1e-5) + 4 * static_cast<double>(extent.rounding);
  const Law& law = law_of(action);
  // If a law prepares, sources need all of their own neighbours, too.
  const double seen = law.prepare != nullptr ? 2 * reach : reach;
  if (!law.looks_ahead) return seen * (1 + 4 * kMargin);
  const double step =
      std::min(static_cast<double>(extent.displacement), static_cast<double>(step_limit(reach_of(action, extent))));
  return (seen + 2 * (step + static_cast<double>(extent.rounding))) * (1 + 4 * kMargin);
}

}  // namespace motes::interactions
