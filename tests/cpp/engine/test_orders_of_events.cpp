// Whole frames on simulated ranks: births, exchange, balance, spawn and pictures give the same bits for any number of
// ranks and any order of events, and balancing decisions repeat with the simulated time. MOTES_TEST_ORDERS sets how
// many orders are tried.
#include <cstdlib>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "balance/named.h"
#include "base/sha256.h"
#include "comm/clock.h"
#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "particles/digest.h"
#include "support/check.h"
#include "support/falling_source.h"
#include "support/owners.h"

namespace motes::test_orders_of_events {
using comm::SimulatedRank;

namespace {

constexpr int kFrames = 6;

struct Way {
  int ranks = 1;
  bool shared = false;  // roles
  engine::Births births = engine::Births::manager;
  engine::Combine combine = engine::Combine::together;
  int fan_out = 8;
  int threads = 1;     // of each rank
  bool reads = false;  // reads particles in the middle of each frame
  image::View::Path path = image::View::Path::automatic;
  domains::Axes axes;
  std::optional<domains::Axes> axes_of_children = domains::Axes{};  // nothing: they share their parents' domains
  bool prefix_cuts = false;
  bool fit = false;
};

// The results of each frame: digests of particles and picture, the parents' cuts, the number of children, and who drew.
struct Film {
  std::vector<std::string> frames;
  std::vector<std::vector<float>> cuts;
  std::vector<std::uint64_t> children;
  std::vector<engine::RenderPlan> plans;
};

std::uint64_t orders() {
  const char* text = std::getenv("MOTES_TEST_ORDERS");
  return text == nullptr ? 200 : std::strtoull(text, nullptr, 10);
}

void record(engine::Engine& engine, int parents, int children, bool reads) {
  const shapes::Shape ground{shapes::Kind::plane, {0, 0, 0, 0, 1, 0}};
  recording::Spawn spawn;
  spawn.into = children;
  spawn.on = recording::Spawn::On::collision;
  spawn.count = 2;
  spawn.inherit_velocity = 0.5;
  engine.record(parents, test::falling_source(60));
  engine.record(parents, spawn);
  engine.record(parents, actions::make(actions::numbers::gravity<>{.acceleration = {0, -9.81, 0}}));
  if (reads) engine.local(parents);
  engine.record(parents, actions::make(actions::numbers::bounce<>{.restitution = 0.5, .friction = 0.1, .exact_hit = 1},
                                       {ground}));
  if (reads) engine.digest();
  engine.record(parents, actions::make(actions::numbers::kill_old<>{.age_limit = 0.2}));
  if (reads) engine.gather(parents, true);
  engine.record(parents, actions::make(actions::numbers::move<>{.rotational = 1}));
  engine.record(children, actions::make(actions::numbers::kill_old<>{.age_limit = 0.1}));
  engine.record(children, actions::make(actions::numbers::move<>{.rotational = 1}));
}

// 3x3 tiles.
constexpr int kWidth = 160, kHeight = 140;

image::View view(image::View::Path path) {
  image::View view;
  view.width = kWidth;
  view.height = kHeight;
  view.path = path;
  view.background = {0.01f, 0.02f, 0.05f};
  view.objects = {{{shapes::Kind::sphere, {0.5f, 0.5f, 0, 0.7f}}, {0.8f, 0.4f, 0.2f}, 0, 0}};
  view.camera.position = {0, 1, 8};
  view.camera.look_at = {0, 1, 0};
  return view;
}

engine::Settings settings(const Way& way) {
  engine::Settings settings;
  settings.seed = 11;
  settings.births = way.births;
  settings.combine = way.combine;
  settings.fan_out = way.fan_out;
  settings.threads = way.threads;
  settings.grain = 16;  // threads share even a few particles
  std::shared_ptr<balance::Policy> policy = balance::policy_named("Pairwise(threshold=0.05, min_particles=4)");
  if (way.prefix_cuts) policy = balance::policy_named("PrefixCuts(threshold=0.05, min_particles=4)");
  policy->speeds.min_particles = 1;
  settings.policy = policy;
  settings.costs.act.fill(2000);
  settings.costs.birth = 500;
  return settings;
}

void play(SimulatedRank& self, const Way& way, Film& film) {
  const roles::Cast cast = way.shared ? roles::cast_shared(way.ranks) : roles::cast_auto(way.ranks);
  auto communicator = std::make_unique<comm::Communicator>(self.transport(), comm::Watch{});
  engine::Engine engine(std::move(communicator), cast, settings(way));
  recording::SystemDefinition definition;
  definition.space = {domains::Space::Kind::finite, -4, 4};
  definition.axes = way.axes;
  if (way.fit) definition.space.kind = domains::Space::Kind::fit;
  definition.name = "parents";
  const int parents = engine.add_system(definition);
  definition.name = "children";
  if (way.axes_of_children) {
    definition.axes = *way.axes_of_children;
  } else {
    definition.domains_of = parents;
  }
  const int children = engine.add_system(definition);
  engine.start();
  for (int i = 0; i < kFrames; ++i) {
    record(engine, parents, children, way.reads);
    engine.run_frame(view(way.path));
    test::check_owners(engine);
    if (definition.domains_of == parents) CHECK(engine.system(parents).domains == engine.system(children).domains);
    const std::string particles = particles::combine(engine.digest()).text();
    if (!engine.session().draws()) continue;
    film.frames.push_back(particles + " " + base::picture_sha256(kWidth, kHeight, engine.painter().take_pixels()));
    film.cuts.push_back(engine.system(parents).domains.cuts());
    film.children.push_back(engine.system(children).counts.alive);
    film.plans.push_back(engine.painter().plan);
  }
  engine.finish();
}

Film run(const Way& way, std::uint64_t seed, std::uint64_t timing) {
  Film film;
  comm::simulate({.ranks = way.ranks, .seed = seed, .timing_seed = timing},
                 [&](SimulatedRank& self) { play(self, way, film); });
  return film;
}

}  // namespace

TEST(frames_are_the_same_bits_on_any_simulated_ranks_in_any_order) {
  const Film alone = run({}, 0, 0);
  CHECK(std::set<std::string>(alone.frames.begin(), alone.frames.end()).size() == kFrames);
  CHECK(alone.children.back() > 20);
  std::set<std::vector<float>> cuts;
  std::set<std::vector<std::uint32_t>> owners;
  std::uint64_t moved = 0;  // cuts of bricks
  for (std::uint64_t seed = 0; seed < orders(); ++seed) {
    Way way;
    way.ranks = seed % 50 == 0 ? 21 : 2 + static_cast<int>(seed % 7);
    way.shared = seed % 2 == 0;
    way.births = seed % 3 == 0 ? engine::Births::calculators : engine::Births::manager;
    way.combine = seed % 5 == 0   ? engine::Combine::one_by_one
                  : seed % 5 == 1 ? engine::Combine::overlapped
                                  : engine::Combine::together;
    way.reads = seed % 4 == 3;
    way.fan_out = 1 + static_cast<int>(seed % 4);
    way.threads = seed % 10 == 9 ? 3 : 1;
    way.path = static_cast<image::View::Path>(seed / 2 % 4);
    // Half of the runs have domains in a row; in a quarter of them children share their parents' domains.
    constexpr std::uint8_t kRows[] = {1, 2, 4, 32, 16};
    way.axes.bits = seed % 2 == 0 ? kRows[seed / 2 % 5] : static_cast<std::uint8_t>(seed / 2 % 8);
    if (seed % 4 == 1) way.axes_of_children.reset();
    if (seed % 4 != 1) way.axes_of_children = domains::Axes{static_cast<std::uint8_t>(seed / 3 % 8)};
    const bool rows = way.axes.row() && (!way.axes_of_children || way.axes_of_children->row());
    way.prefix_cuts = !rows;
    way.fit = seed % 6 == 5;
    const Film film = run(way, seed, seed);
    CHECK(film.frames == alone.frames && film.children == alone.children);
    cuts.insert(film.cuts.back());
    if (way.axes.bricks()) moved += static_cast<std::uint64_t>(film.cuts.front() != film.cuts.back());
    owners.insert(film.plans.back().ends);
  }
  CHECK(cuts.size() > orders() / 3);  // balancing moved them, by the simulated time
  CHECK(owners.size() > 10);
  CHECK(moved > orders() / 10);
}

TEST(what_balancing_decides_repeats_with_the_simulated_time) {
  for (const bool shared : {false, true}) {
    Way way;
    way.ranks = 6;
    way.shared = shared;
    const Film model = run(way, 0, 3);
    for (std::uint64_t seed = 1; seed < 20; ++seed) CHECK(run(way, seed, 3).cuts == model.cuts);
    CHECK(run(way, 0, 4).cuts != model.cuts);
    CHECK(model.cuts.front() != model.cuts.back());
  }
}

namespace {

// A policy that takes a simulated second to plan.
class Slow final : public balance::Policy {
 public:
  const char* kind() const override { return "Slow"; }
  balance::Plan plan(const balance::LoadTable&) const override {
    comm::execute(1e9);
    return {};
  }
};

// The longest time that a rank waited for the verdict, drew, or planned.
struct Waits {
  double verdict_s = 0;
  double draw_s = 0;
  double plan_s = 0;
};

Waits waits_of(engine::Combine combine) {
  Waits waits;
  comm::simulate({.ranks = 5}, [&](SimulatedRank& self) {
    Way way;
    way.combine = combine;
    engine::Settings slow = settings(way);
    slow.policy = std::make_shared<Slow>();
    engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), roles::cast_auto(5),
                          slow);
    recording::SystemDefinition definition;
    definition.name = "parents";
    engine.add_system(definition);
    definition.name = "children";
    engine.add_system(definition);
    engine.start();
    record(engine, 0, 1, false);
    engine.run_frame(view(image::View::Path::automatic));
    if (engine.session().calculates()) {
      waits.verdict_s = std::max(waits.verdict_s, engine.times().report);
      waits.plan_s = std::max(waits.plan_s, engine.times().balance);
    }
    if (engine.session().draws()) waits.draw_s = engine.times().render;
    engine.finish();
  });
  return waits;
}

}  // namespace

TEST(nobody_waits_for_the_plan_before_particles_and_picture_are_under_way) {
  for (const engine::Combine combine : {engine::Combine::together, engine::Combine::one_by_one}) {
    const Waits waits = waits_of(combine);
    CHECK(waits.plan_s > 0.5);
    CHECK(waits.verdict_s < 0.5);
    CHECK(waits.draw_s < 0.5);
  }
}

}  // namespace motes::test_orders_of_events
