// Frames in which particles meet, on simulated ranks: the same bits for any number of ranks, any domains and any order
// of events; a rank that fails, or has a different list, stops all of them. MOTES_TEST_ORDERS sets how many orders are
// tried.
#include <cstdlib>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "balance/named.h"
#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "particles/digest.h"
#include "support/check.h"
#include "support/forwarding_transport.h"

namespace motes::test_orders_of_meetings {
using actions::Action;
using actions::Kind;
using comm::SimulatedRank;

namespace {

constexpr int kFrames = 5;
enum : int { grains, pebbles, sparks };  // systems; grains and pebbles meet

struct Way {
  int ranks = 1;
  bool shared = false;  // roles
  domains::Axes axes;
  bool own_domains = true;  // whether pebbles have other domains than grains
  bool prefix = false;  // PrefixCuts instead of Pairwise
  engine::Births births = engine::Births::manager;
  engine::Combine combine = engine::Combine::together;
  int threads = 1;
};

std::uint64_t orders() {
  const char* text = std::getenv("MOTES_TEST_ORDERS");
  return text == nullptr ? 120 : std::strtoull(text, nullptr, 10);
}

recording::Source source(double rate, float half, float speed) {
  recording::Source source;
  source.shape = {shapes::Kind::box, {-3, 0.1f, -half, 2, 1, half}};
  source.rate = 24 * rate;
  source.jitter = true;
  const actions::distributions::InShape velocity{{shapes::Kind::sphere, {0, -3, 0, speed}}};
  source.state = {{particles::velocity, velocity}};
  return source;
}

recording::Spawn spawn(recording::Spawn::On on) {
  recording::Spawn rule;
  rule.into = sparks;
  rule.on = on;
  rule.inherit_velocity = 0.5;
  return rule;
}

Action collide(double radius, double restitution, double other_radius = 0) {
  return actions::make(actions::numbers::collide<>{
      .radius = radius, .restitution = restitution, .friction = 0.5, .sleep = -1, .other_radius = other_radius});
}
Action gravity() { return actions::make(actions::numbers::gravity<>{.acceleration = {0, -9.81, 0}}); }
Action bounce() { return {Kind::bounce, {0.5, 0.1, 0, 1}, {{shapes::Kind::plane, {0, 0, 0, 0, 1, 0}}}}; }
Action kill_old(double age) { return actions::make(actions::numbers::kill_old<>{.age_limit = age}); }
Action move() { return actions::make(actions::numbers::move<>{.rotational = 1}); }

// Returns an action that throws particles over several domains in one step.
Action far_away(int frame) {
  Action set = actions::make(actions::numbers::set<>{});
  auto& opposite = set.specifics.emplace<actions::Assignment>();
  opposite.attribute = particles::position;
  for (int c = 0; c < 3; ++c) {
    opposite.values.push_back({{actions::Op::column, c, 0}, {actions::Op::constant, 0, -1}, {actions::Op::multiply}});
  }
  set.where = {{actions::Op::constant, 0, 1.5f + 0.1f * static_cast<float>(frame)},
               {actions::Op::column, 0, 0},
               {actions::Op::less}};
  return set;
}

void record(engine::Engine& engine, int frame) {
  using On = recording::Spawn::On;
  engine.record(grains, source(60, 1, 4));
  engine.record(grains, spawn(On::collision));
  engine.record(grains, gravity());
  engine.record(grains, collide(0.15, 0.25));
  engine.record(grains, bounce());
  engine.record(grains, far_away(frame));
  engine.record(grains, source(9, 0.1f, 0.5f));  // in the middle of the list
  engine.record(grains, kill_old(0.15));
  engine.record(pebbles, source(20, 1, 6));
  engine.record(pebbles, spawn(On::birth));
  engine.record_interaction(grains, pebbles, collide(0.1, 0.5, 0.3));
  engine.record(pebbles, gravity());
  engine.record(pebbles, spawn(On::death));
  engine.record(pebbles, collide(0.3, 0));
  engine.record(pebbles, bounce());
  engine.record(pebbles, kill_old(0.12));
  engine.record(pebbles, move());
  engine.record(
      grains, actions::make(actions::numbers::match_velocity<>{.magnitude = 0.01, .epsilon = 1e-3, .max_radius = 0.3}));
  engine.record(grains, move());
  engine.record(sparks, actions::make(actions::numbers::gravitate<>{
                            .magnitude = 0.1, .epsilon = 1e-3, .max_radius = frame % 2 == 0 ? INFINITY : 0.5}));
  engine.record(sparks, kill_old(0.12));
  engine.record(sparks, move());
}

engine::Settings settings(const Way& way) {
  engine::Settings settings;
  settings.seed = 12;
  settings.substeps = 2;
  settings.births = way.births;
  settings.combine = way.combine;
  settings.threads = way.threads;
  settings.grain = 16;
  if (way.prefix || !way.axes.row()) {
    settings.policy = balance::policy_named("PrefixCuts(threshold=0.01, min_particles=1)");
  } else {
    const auto policy = balance::policy_named("Pairwise(threshold=0.01, min_particles=1)");
    policy->speeds.min_particles = 1;
    settings.policy = policy;
  }
  settings.costs.act.fill(2000);
  return settings;
}

std::unique_ptr<engine::Engine> engine_of(std::unique_ptr<comm::Transport> transport, const Way& way) {
  const roles::Cast cast = way.shared ? roles::cast_shared(way.ranks) : roles::cast_auto(way.ranks);
  auto communicator = std::make_unique<comm::Communicator>(std::move(transport), comm::Watch{});
  auto engine = std::make_unique<engine::Engine>(std::move(communicator), cast, settings(way));
  recording::SystemDefinition definition;
  definition.axes = way.axes;
  definition.space = {domains::Space::Kind::finite, -2, 2};
  for (const char* name : {"grains", "pebbles", "sparks"}) {
    definition.name = name;
    const int index = engine->add_system(definition);
    if (!way.own_domains && index == grains) definition.domains_of = grains;
  }
  return engine;
}

// The results of each frame: digests of the systems, and how many sparks there are.
struct Run {
  std::vector<std::string> frames;
  std::vector<std::uint64_t> counts;
  std::vector<float> cuts;
};

Run run(const Way& way, std::uint64_t seed) {
  Run run;
  comm::simulate({.ranks = way.ranks, .seed = seed}, [&](SimulatedRank& self) {
    const auto engine = engine_of(self.transport(), way);
    engine->start();
    for (int i = 0; i < kFrames; ++i) {
      record(*engine, i);
      engine->run_frame(std::nullopt);
      std::string text;
      for (const particles::Digest& digest : engine->digest()) text += digest.text() + " ";
      if (!engine->session().manages()) continue;
      run.frames.push_back(text);
      for (int s = 0; s < 3; ++s) run.counts.push_back(engine->system(s).counts.alive);
      run.cuts = engine->system(grains).domains.cuts();
    }
    engine->finish();
  });
  return run;
}

Way way_of(std::uint64_t seed) {
  constexpr int kRanks[] = {2, 3, 5, 8};
  Way way;
  way.ranks = seed % 25 == 24 ? 13 : kRanks[seed % 4];
  way.shared = seed / 4 % 2 == 0;
  constexpr std::uint8_t kAxes[] = {0, 1, 2, 3, 16, 4, 5, 6, 7, 32};
  way.axes.bits = kAxes[seed * 7 % 10];
  way.own_domains = seed % 3 != 0;
  way.prefix = seed % 5 < 2;
  way.births = seed % 7 < 3 ? engine::Births::calculators : engine::Births::manager;
  way.combine = static_cast<engine::Combine>(seed / 8 % 3);
  way.threads = seed % 10 == 9 ? 3 : 1;
  return way;
}

}  // namespace

TEST(frames_with_meetings_are_the_same_bits_on_any_simulated_ranks) {
  const Run alone = run({}, 0);
  CHECK(std::set<std::string>(alone.frames.begin(), alone.frames.end()).size() == kFrames);
  for (std::size_t s = 0; s < 3; ++s) CHECK(alone.counts[alone.counts.size() - 3 + s] > 20);
  std::set<std::vector<float>> cuts;
  for (std::uint64_t seed = 0; seed < orders(); ++seed) {
    const Run other = run(way_of(seed), seed);
    if (other.frames != alone.frames || other.counts != alone.counts)
      check::fail(__FILE__, __LINE__, "the order " + std::to_string(seed));
    cuts.insert(other.cuts);
  }
  CHECK(cuts.size() > orders() / 10);  // balancing moved them, by the simulated time
}

namespace {

// What goes wrong on one rank in the last frame.
struct Fault {
  enum Kind { before, in, behind, without, more } kind = before;
  int rank = 0;
  int ranks = 3;
};

constexpr int kLast = 1;  // frame

// Changes a message of a meeting, so that it has another number of particles than its header says.
class Distorting final : public test::Forwarding {
 public:
  Distorting(std::unique_ptr<Transport> under, const int& meetings)
      : Forwarding(std::move(under)), meetings_(meetings) {}
  std::optional<base::Bytes> receive(int from, Phase phase) override {
    std::optional<base::Bytes> bytes = Forwarding::receive(from, phase);
    if (!bytes || phase != Phase::interaction || ++seen_[from] != meetings_) return bytes;
    comm::Message message(std::move(*bytes));
    comm::Header header = message.header();
    ++header.count;
    message.set_header(header);
    return std::move(message.bytes());
  }

 private:
  const int& meetings_;  // index of the distorted message among those from each rank
  std::map<int, int> seen_;
};

// Records four meetings among three callbacks, each of which may fail.
void record_faulty(engine::Engine& engine, bool last, const Fault* fault) {
  int callbacks = 0;
  int meetings = 4;
  if (fault != nullptr && last) meetings += fault->kind == Fault::more ? 1 : fault->kind == Fault::without ? -4 : 0;
  engine.record(grains, source(60, 1, 4));
  for (int m = 0; m < meetings; ++m) {
    engine.record(grains, collide(0.4, 0.5));
    if (m > 0 && m < 4) engine.record(grains, recording::Callback{"look", callbacks++});
  }
  engine.record(grains, move());
}

// How each rank ended: the kind of failure and the rank that failed, or the exception that it threw itself.
using Ends = std::map<int, std::string>;

void play(SimulatedRank& self, const Fault& fault, bool shared, Ends& ends) {
  const bool faulty = self.rank() == fault.rank;
  int distorted = -1;
  std::unique_ptr<comm::Transport> transport = self.transport();
  if (faulty && fault.kind == Fault::in) transport = std::make_unique<Distorting>(std::move(transport), distorted);
  Way way;
  way.ranks = fault.ranks;
  way.shared = shared;
  const auto engine = engine_of(std::move(transport), way);
  int frame = 0;
  engine->on_callback([&](const engine::Call& call) {
    const int fails = fault.kind == Fault::before ? 0 : fault.kind == Fault::behind ? 1 : -1;
    if (faulty && frame == kLast && call.callback == fails) throw std::runtime_error("the callback broke");
  });
  distorted = 2 * 4 * kLast + 3;  // two sub-steps of four meetings in each frame before
  try {
    engine->start();
    for (; frame <= kLast; ++frame) {
      record_faulty(*engine, frame == kLast, faulty ? &fault : nullptr);
      engine->run_frame(std::nullopt);
    }
    engine->digest();
    ends[self.rank()] = "all went well";
  } catch (const engine::Agreed& agreed) {
    const bool mismatch = agreed.verdict().failure.kind == engine::Failure::Kind::mismatch;
    ends[self.rank()] = (mismatch ? "differs: " : "failed: ") + std::to_string(agreed.verdict().failed_rank);
  } catch (const comm::Deadlock&) {
    ends[self.rank()] = "waits";
  } catch (const std::runtime_error& error) {
    ends[self.rank()] = error.what();
  }
}

void check_ends(const Fault& fault, bool shared, std::uint64_t seed) {
  Ends ends;
  try {
    comm::simulate({.ranks = fault.ranks, .seed = seed}, [&](SimulatedRank& self) { play(self, fault, shared, ends); });
  } catch (const comm::Deadlock& seen) {
    check::fail(__FILE__, __LINE__, seen.what());
  }
  const bool differs = fault.kind == Fault::without || fault.kind == Fault::more;
  for (int r = 0; r < fault.ranks; ++r) {
    std::string wanted = (differs ? "differs: " : "failed: ") + std::to_string(fault.rank);
    if (!differs && r == fault.rank)
      wanted = fault.kind == Fault::in ? "particles were lost on the way between calculators" : "the callback broke";
    if (ends[r] != wanted)
      check::fail(__FILE__, __LINE__,
                  "fault " + std::to_string(fault.kind) + " on rank " + std::to_string(fault.rank) + " of " +
                      std::to_string(fault.ranks) + ", rank " + std::to_string(r) + ": " + ends[r]);
  }
}

}  // namespace

TEST(a_rank_that_fails_at_a_meeting_stops_all) {
  for (const Fault::Kind kind : {Fault::before, Fault::in, Fault::behind}) {
    for (const int ranks : {2, 3, 5, 8}) {
      for (const bool shared : {false, true}) {
        const roles::Cast cast = shared ? roles::cast_shared(ranks) : roles::cast_auto(ranks);
        for (const int rank : cast.calculators) {
          if (kind == Fault::in && cast.calculators.size() < 2) continue;
          for (std::uint64_t seed = 0; seed < 3; ++seed) check_ends({kind, rank, ranks}, shared, seed);
        }
      }
    }
  }
}

TEST(a_rank_whose_list_meets_elsewhere_is_found_out) {
  for (const Fault::Kind kind : {Fault::without, Fault::more}) {
    for (const int ranks : {3, 5, 8}) {
      for (const bool shared : {false, true}) {
        for (int rank = 0; rank < ranks; ++rank) {
          for (std::uint64_t seed = 0; seed < 2; ++seed) check_ends({kind, rank, ranks}, shared, seed);
        }
      }
    }
  }
}

}  // namespace motes::test_orders_of_meetings
