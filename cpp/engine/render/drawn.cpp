#include "engine/render/drawn.h"

#include <algorithm>
#include <cstring>

#include "actions/action.h"
#include "actions/kernels.h"
#include "program/planes.h"

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
  d.ids = store.ids();
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
  from(part.tile);
  if (part.ids.lower != nullptr) part.ids = part.ids.from(first);
  return part;
}

const float* tile_numbers(const image::Pick& pick, particles::Store& store, std::size_t first, std::size_t count,
                          double time, std::vector<float>& memory) {
  if (pick.number.empty()) return nullptr;
  memory.resize(actions::kScratch + count + 2 * particles::kPadding);
  float* const stack = memory.data();
  float* const numbers = stack + actions::kScratch;
  program::Planes planes(store, actions::columns_of(pick.number, store.schema()));
  for (std::size_t done = 0; done < count; done += particles::kBlock) {
    const std::size_t length = std::min(particles::kBlock, count - done);
    const actions::Block block{length, planes.at(first + done), store.ids().from(first + done), nullptr};
    actions::kernels().evaluate(pick.number.data(), pick.number.size(), pick.shapes.data(), block,
                                static_cast<float>(time), stack);
    std::memcpy(numbers + done, stack, length * sizeof(float));
  }
  return numbers;
}

image::Projection projection(const Script& script, std::size_t system) {
  image::Projection p;
  p.system = static_cast<int>(system);
  const auto& view = script.record.view;
  p.any_depth = view && image::anything_hides(*view, script.record.sprites);
  p.in_order = image::in_order_of_depth(script.record.sprites);
  p.dt = script.record.dt;
  const particles::Key key = particles::system_key(script.record.seed, static_cast<std::uint32_t>(system));
  p.pick = particles::draw_key(key, 0, particles::sprite_tile, 0);
  return p;
}

}  // namespace motes::engine
