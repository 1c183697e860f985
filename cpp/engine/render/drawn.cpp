#include "engine/render/drawn.h"

#include <algorithm>

#include "interactions/clumps.h"

namespace motes::engine {

image::Drawn drawn(const particles::Store& store) {
  image::Drawn d;
  const auto three = [&](int attribute, std::array<const float*, 3>& planes, std::array<float, 3>& of_all) {
    const particles::Value value = store.uniform_value(attribute);
    for (int c = 0; c < 3; ++c) planes[static_cast<std::size_t>(c)] = store.plane(attribute, c);
    std::copy_n(value.begin(), 3, of_all.begin());
  };
  std::array<float, 3> nowhere{};
  d.count = store.size();
  three(particles::position, d.position, nowhere);
  three(particles::color, d.color, d.color_of_all);
  three(particles::up, d.up, d.up_of_all);
  three(particles::velocity, d.velocity, d.velocity_of_all);
  for (int c = 0; c < 4; ++c) d.orientation[static_cast<std::size_t>(c)] = store.plane(particles::orientation, c);
  d.orientation_of_all = store.uniform_value(particles::orientation);
  d.alpha = store.plane(particles::alpha, 0);
  d.alpha_of_all = store.uniform_value(particles::alpha)[0];
  d.size = store.plane(particles::size, 0);
  d.size_of_all = store.uniform_value(particles::size)[0];
  if (d.position[0] == nullptr) d.count = 0;  // no particle was ever here
  return d;
}

DrawnSystem::DrawnSystem(const particles::Store& store, const image::Sprite& sprite, actions::TableKey clumps,
                         threads::Pool& pool)
    : drawn_(drawn(store)) {
  if (clumps != 0 && sprite.kind != image::Sprite::Kind::mesh && drawn_.count > 0) expand(store, clumps, pool);
}

// Sphere k of the i-th of n clumps stands at k * n + i.
void DrawnSystem::expand(const particles::Store& store, actions::TableKey clumps, threads::Pool& pool) {
  const std::vector<interactions::ClumpSphere> spheres = interactions::spheres_of(clumps);
  const std::size_t count = store.size();
  drawn_.count = count * spheres.size();
  float* placed[interactions::sphere_columns];
  for (float*& plane : placed) plane = planes_.emplace_back(drawn_.count + 2 * particles::kPadding).data();
  interactions::place_spheres(store, spheres, placed, pool);
  for (std::size_t c = 0; c < 3; ++c) {
    drawn_.position[c] = placed[interactions::sphere_x + c];
    drawn_.velocity[c] = placed[interactions::sphere_velocity + c];
    drawn_.color[c] = repeat(drawn_.color[c], count);
    drawn_.up[c] = repeat(drawn_.up[c], count);
  }
  for (const float*& plane : drawn_.orientation) plane = repeat(plane, count);
  drawn_.alpha = repeat(drawn_.alpha, count);
  drawn_.size = placed[interactions::sphere_size];
}

// Gives each sphere its clump's value.
const float* DrawnSystem::repeat(const float* plane, std::size_t clumps) {
  if (plane == nullptr) return nullptr;
  std::vector<float>& values = planes_.emplace_back(drawn_.count + 2 * particles::kPadding);
  for (std::size_t n = 0; n < drawn_.count; n += clumps)
    std::copy_n(plane, clumps, values.begin() + static_cast<std::ptrdiff_t>(n));
  return values.data();
}

std::vector<DrawnSystem> drawn_systems(const Script& script, const Calculator& calculator, threads::Pool& pool) {
  std::vector<DrawnSystem> systems;
  for (std::size_t i = 0; i < calculator.populations.size(); ++i)
    systems.emplace_back(calculator.populations[i]->store, script.record.sprites[i], script.record.clumps[i], pool);
  return systems;
}

image::Drawn part_of(const image::Drawn& all, std::size_t first, std::size_t count) {
  image::Drawn part = all;
  part.count = count;
  const auto from = [first](const float*& plane) {
    if (plane != nullptr) plane += first;
  };
  for (auto* planes : {&part.position, &part.color, &part.up, &part.velocity}) {
    for (const float*& plane : *planes) from(plane);
  }
  for (const float*& plane : part.orientation) from(plane);
  from(part.alpha);
  from(part.size);
  return part;
}

image::Projection projection(const Script& script, std::size_t system) {
  image::Projection p;
  p.system = static_cast<int>(system);
  const auto& view = script.record.view;
  p.any_depth = view && image::anything_hides(*view, script.record.sprites);
  p.in_order = image::in_order_of_depth(script.record.sprites);
  p.dt = script.record.dt;
  return p;
}

}  // namespace motes::engine
