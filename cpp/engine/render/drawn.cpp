#include "engine/render/drawn.h"

#include <algorithm>
#include <cstring>

#include "actions/action.h"
#include "actions/kernels.h"
#include "interactions/clumps.h"
#include "particles/trace.h"
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
  three(particles::spin, d.spin, d.spin_of_all);
  for (int c = 0; c < 4; ++c) d.orientation[static_cast<std::size_t>(c)] = store.plane(particles::orientation, c);
  d.orientation_of_all = store.uniform_value(particles::orientation);
  d.alpha = store.plane(particles::alpha, 0);
  d.alpha_of_all = store.uniform_value(particles::alpha)[0];
  d.size = store.plane(particles::size, 0);
  d.size_of_all = store.uniform_value(particles::size)[0];
  if (d.position[0] == nullptr) d.count = 0;  // there was never a particle
  return d;
}

namespace {

// Returns the number of the frame that is drawn; a redraw happens while the next one is recorded.
std::uint64_t drawn_frame(const Script& script) {
  return script.record.frame - (script.record.verb == recording::Verb::redraw ? 1 : 0);
}

// Returns a system's columns, with past positions if its sprite is a ribbon.
image::Drawn traced(const Script& script, std::size_t system, const particles::Store& store) {
  image::Drawn d = drawn(store);
  const auto* ribbon = script.record.sprites[system].as<image::RibbonSprite>();
  const int count = store.schema().find(particles::kTraceCount);
  if (const auto* liquid = script.record.sprites[system].as<image::LiquidSprite>()) {
    d.size = nullptr;
    d.size_of_all = 2 * liquid->radius;
  }
  if (ribbon == nullptr) return d;
  d.size = nullptr;
  d.size_of_all = ribbon->width;
  if (count < 0) return d;
  d.past_count = store.plane(count, 0);
  const auto times = particles::TraceTimes::over(ribbon->length, script.record.dt, drawn_frame(script));
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

// Computes the sprite tile numbers of all particles. `time`: seconds of the animation.
void number_tiles(const image::Pick& pick, particles::Store& store, double time, float* numbers, threads::Pool& pool) {
  constexpr std::size_t kRange = std::size_t{1} << 15;
  const std::uint64_t read = actions::columns_of(pick.number, store.schema());
  threads::over_ranges(pool, store.size(), kRange, [&](std::size_t first, std::size_t last) {
    std::vector<float> stack(actions::kScratch);
    program::Planes planes(store, read);
    for (std::size_t i = first; i < last; i += particles::kBlock) {
      const std::size_t length = std::min(particles::kBlock, last - i);
      const actions::Block block{length, planes.at(i), store.ids().from(i), nullptr};
      actions::kernels().evaluate(pick.number.data(), pick.number.size(), pick.shapes.data(), block,
                                  static_cast<float>(time), stack.data());
      std::memcpy(numbers + i, stack.data(), length * sizeof(float));
    }
  });
}

}  // namespace

DrawnSystem::DrawnSystem(const Script& script, std::size_t system, particles::Store& store, threads::Pool& pool)
    : number_(system), drawn_(traced(script, system, store)) {
  const image::Sprite& sprite = script.record.sprites[system];
  const image::Sheet* sheet = sprite.sheet();
  if (sheet != nullptr && !sheet->pick.number.empty() && drawn_.count > 0) {
    const double time = static_cast<double>(drawn_frame(script) + 1) * script.record.dt;
    std::vector<float>& numbers = planes_.emplace_back(drawn_.count + 2 * particles::kPadding);
    number_tiles(sheet->pick, store, time, numbers.data(), pool);
    drawn_.tile = numbers.data();
  }
  const actions::TableKey clumps = script.record.clumps[system];
  const bool whole = sprite.is(image::Sprite::Kind::mesh) || sprite.is(image::Sprite::Kind::ribbon);
  if (clumps != 0 && !whole && drawn_.count > 0) expand(store, clumps, pool);
}

// Replaces clumps with their spheres: sphere k of clump i of n is at index k * n + i.
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
    drawn_.spin[c] = repeat(drawn_.spin[c], count);
  }
  for (const float*& plane : drawn_.orientation) plane = repeat(plane, count);
  drawn_.alpha = repeat(drawn_.alpha, count);
  drawn_.tile = repeat(drawn_.tile, count);
  std::vector<std::uint64_t> ids(drawn_.count);
  for (std::size_t n = 0; n < drawn_.count; n += count) particles::join(drawn_.ids, count, ids.data() + n);
  ids_ = particles::IdList(ids);
  drawn_.ids = ids_;
  drawn_.size = placed[interactions::sphere_size];
}

// Returns a plane that gives each sphere its clump's value.
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
    systems.emplace_back(script, i, calculator.populations[i]->store, pool);
  return systems;
}

image::Drawn part_of(const image::Drawn& all, std::size_t first, std::size_t count) {
  image::Drawn part = all;
  part.count = count;
  const auto from = [first](const float*& plane) {
    if (plane != nullptr) plane += first;
  };
  for (auto* planes : {&part.position, &part.color, &part.up, &part.velocity, &part.spin}) {
    for (const float*& plane : *planes) from(plane);
  }
  for (const float*& plane : part.orientation) from(plane);
  from(part.alpha);
  from(part.size);
  from(part.past_count);
  for (image::Past& past : part.past) {
    for (const float*& plane : past.position) from(plane);
  }
  from(part.tile);
  if (part.ids.lower != nullptr) part.ids = part.ids.from(first);
  return part;
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
