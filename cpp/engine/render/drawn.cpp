#include "engine/render/drawn.h"

#include <algorithm>

#include "particles/trace.h"

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

image::Drawn drawn(const Script& script, std::size_t system, const particles::Store& store) {
  image::Drawn d = drawn(store);
  const image::Sprite& sprite = script.record.sprites[system];
  const int count = store.schema().find(particles::kTraceCount);
  if (sprite.kind != image::Sprite::Kind::ribbon) return d;
  d.size = nullptr;
  d.size_of_all = sprite.width;
  if (count < 0) return d;
  d.past_count = store.plane(count, 0);
  // After a frame the next one is already being recorded.
  const std::uint64_t frame = script.record.frame - (script.record.verb == recording::Verb::redraw ? 1 : 0);
  const auto times = particles::TraceTimes::over(sprite.length, script.record.dt, frame);
  static_assert(image::kMostPast == particles::kTraced);
  for (int back = 0; back < particles::kTraced; ++back) {
    image::Past& past = d.past[static_cast<std::size_t>(back)];
    past.age = static_cast<float>(static_cast<double>(times.age(back)) * script.record.dt);
    for (int c = 0; c < 3; ++c) {
      past.position[static_cast<std::size_t>(c)] = store.plane(count + 1 + times.slot(back), c);
    }
  }
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
  from(part.past_count);
  for (image::Past& past : part.past) {
    for (const float*& plane : past.position) from(plane);
  }
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
