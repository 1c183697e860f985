#include "lab/soak/story.h"

#include <memory>
#include <vector>

#include "actions/tables.h"
#include "balance/named.h"
#include "particles/trace.h"

namespace motes::soak {
namespace {

using actions::Action;
using actions::make;
namespace numbers = actions::numbers;

// Returns a law of a script: pairs remember the sum of their normals, which pushes them apart.
Action law() {
  using actions::Leaf;
  using actions::Op;
  using actions::Result;
  Action action = make(numbers::interact<>{.radius = 0.3, .state = 3});
  auto& law = std::get<actions::PairLaw>(action.specifics);
  for (std::int32_t c = 0; c < 3; ++c) {
    law.leaves.push_back({Leaf::Of::state, 0, c});
    law.leaves.push_back({Leaf::Of::normal, 0, c});
    const actions::Expression next = {{Op::column, 2 * c}, {Op::column, 2 * c + 1}, {Op::subtract}};
    law.values.insert(law.values.end(), 2, next);
    law.results.push_back({Result::How::state, 0, c});
    law.results.push_back({Result::How::rate, particles::velocity, c});
  }
  return action;
}

recording::Source falling(double per_frame) {
  recording::Source source;
  source.shape = {shapes::Kind::box, {-3, 0.2f, -1, 0.5f, 2, 1}};
  source.rate = 24 * per_frame;
  const actions::distributions::InShape velocity{{shapes::Kind::sphere, {1, -4, 0, 6}}};
  source.state = {{particles::velocity, velocity}};
  return source;
}

roles::Cast random_cast(Random& random, int ranks) {
  if (random.below(3) == 0) return roles::cast_shared(ranks);
  if (random.below(2) == 0) return roles::cast_auto(ranks);
  const auto any = [&] { return static_cast<int>(random.below(static_cast<std::size_t>(ranks))); };
  roles::Cast cast{any(), any(), {}};
  for (int rank = 0; rank < ranks; ++rank) {
    if (random.below(4) > 0) cast.calculators.push_back(rank);
  }
  if (cast.calculators.empty()) cast.calculators.push_back(any());
  return cast;
}

std::shared_ptr<balance::Policy> policy(const Way& way) {
  std::shared_ptr<balance::Policy> policy;
  if (way.balancer == 1) policy = balance::policy_named("Pairwise(threshold=0.05, min_particles=4)");
  if (way.balancer == 2) policy = balance::policy_named("Diffusive(threshold=0.05, rate=0.5, min_particles=4)");
  if (way.balancer == 3) policy = balance::policy_named("PrefixCuts(threshold=0.05, min_particles=4)");
  if (policy) policy->speeds.min_particles = 1;
  return policy;
}

}  // namespace

Story random_story(Random& random) {
  Story story;
  const auto maybe = [&] { return random.below(2) == 0; };
  story.reads = maybe();
  story.sub_steps = !story.reads && maybe();
  story.meets = random.below(4) == 0;
  story.pictures = random.below(3) > 0;
  story.streaks = story.pictures && maybe();
  return story;
}

Way random_way(Random& random) {
  Way way;
  constexpr int kRanks[] = {1, 2, 3, 4, 5, 5, 8, 13};
  constexpr std::uint8_t kAxes[] = {1, 1, 2, 3, 7, 0, 16, 32};
  way.ranks = kRanks[random.below(8)];
  way.cast = random_cast(random, way.ranks);
  way.axes = kAxes[random.below(8)];
  way.combine = static_cast<engine::Combine>(random.below(3));
  way.births = random.below(2) == 0 ? engine::Births::manager : engine::Births::calculators;
  way.threads = 1 + static_cast<int>(random.below(8) == 0);
  way.fan_out = random.below(2) == 0 ? 8 : 2;
  way.balancer =
      domains::Axes{way.axes}.row() ? static_cast<int>(random.below(4)) : 3 * static_cast<int>(random.below(2));
  way.path = static_cast<image::View::Path>(random.below(4));
  return way;
}

engine::Settings settings(const Story& story, const Way& way) {
  engine::Settings settings;
  settings.seed = 4;
  settings.substeps = story.sub_steps ? 2 : 1;
  settings.combine = way.combine;
  settings.births = way.births;
  settings.threads = way.threads;
  settings.grain = 16;
  settings.fan_out = way.fan_out;
  settings.policy = policy(way);
  settings.costs.act.fill(2000);
  return settings;
}

void define(engine::Engine& engine, const Way& way) {
  recording::SystemDefinition definition;
  definition.space = {domains::Space::Kind::finite, -3.2, 0.8};
  definition.axes.bits = way.axes;
  definition.name = "parents";
  engine.add_system(definition);
  engine.system(0).outside.clumps = actions::keep({{2, 1, 1}, 4, {-0.1f, 0, 0, 0.1f, 0.1f, 0, 0, 0.1f}});
  definition.name = "children";
  definition.capacity = 90;
  definition.sprite.look = image::RibbonSprite{0.1f, 0.3f};  // which keep where the children have been
  for (const auto& [name, width] : particles::trace_attributes(false))
    definition.attributes.push_back({name, width, {}});
  engine.add_system(definition);
}

namespace {

// Tells the engine in some frames, outside the list, how parents are drawn from then on.
void tell(engine::Engine& engine, std::uint64_t frame) {
  if (frame % 3 != 0) return;
  image::Sprite sprite;
  sprite.pixels = 3 + static_cast<int>(frame % 7);
  engine.set_sprite(0, sprite);
}

}  // namespace

void record(engine::Engine& engine, const Story& story, std::uint64_t frame) {
  tell(engine, frame);
  const shapes::Shape ground{shapes::Kind::plane, {0, 0, 0, 0, 1, 0}};
  recording::Spawn spawn;
  spawn.into = 1;
  spawn.on = recording::Spawn::On::collision;
  spawn.count = 2;
  engine.record(0, falling(30 + 0.45 * static_cast<double>(frame % 3)));  // fractions of particles carry over
  if (story.reads && frame % 2 == 0) engine.digest();
  engine.record(0, spawn);
  engine.record(0, make(numbers::gravity<>{.acceleration = {0, -9.81, 0}}));
  if (story.reads && frame % 3 == 1) engine.gather(0, true);
  engine.record(0, make(numbers::bounce<>{.restitution = 0.5, .friction = 0.1, .exact_hit = 1}, {ground}));
  engine.record(0, make(numbers::kill_old<>{.age_limit = 0.4}));
  // From here on values at birth are needed, also those of particles that were born before.
  if (frame > 5) engine.record(0, make(numbers::restore<>{.time_left = 1, .position = 1, .up = 1}));
  if (story.meets) {
    engine.record(0, make(numbers::match_velocity<>{.magnitude = 0.5, .epsilon = 0.1, .max_radius = 0.3}));
    engine.record(0, law());
  }
  engine.record(0, make(numbers::move<>{.rotational = 1}));
  engine.record(1, falling(10));
  engine.record(1, make(numbers::kill_old<>{.age_limit = 0.2}));
  engine.record(1, make(numbers::move<>{.rotational = 1}));
}

std::optional<image::View> view(const Story& story, const Way& way, std::uint64_t frame) {
  if (!story.pictures) return {};
  image::View view;
  view.width = kWidth;
  view.height = kHeight;
  view.path = way.path;
  view.shutter = story.streaks ? 0.5f : 0;
  view.camera.position = {0.05f * static_cast<float>(frame), 1, 8};
  view.camera.look_at = {0, 1, 0};
  return view;
}

}  // namespace motes::soak
