#include "lab/bench/bench_actions.h"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>

#include "lab/bench/bench_scene.h"
#include "program/order.h"
#include "program/program.h"

namespace motes::bench {
namespace {

using namespace recording;

using actions::Action;
using actions::Kind;
using actions::make;
namespace numbers = actions::numbers;
using particles::Store;
using shapes::Shape;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kDt = 1.0 / 1024;  // so short that hundreds of steps leave the scene as it was

const Shape kGust{shapes::Kind::box, {-2, -1, -2, 2, 1, 2}};
const Shape kGround{shapes::Kind::plane, {0, 0, 0, 0, 1, 0}};
const Shape kNowhere{shapes::Kind::box, {900, 900, 900, 901, 901, 901}};
const Shape kHalf{shapes::Kind::box, {-50, 0, -50, 0, 50, 50}};
const Shape kBall{shapes::Kind::sphere, {0, 25, 0, 10, 0}};

// Parameters of the actions whose cost would be unusual with arbitrary parameters.
const std::map<std::string, Action>& usual() {
  static const std::map<std::string, Action> all = {
      {"damping", make(numbers::damping<>{.damping = {0.9, 0.9, 0.9}, .max_speed = kInf})},
      {"rotational_damping", make(numbers::rotational_damping<>{.damping = {0.9, 0.9, 0.9}, .max_speed = kInf})},
      {"bounce", make(numbers::bounce<>{.restitution = 0.1, .friction = 0.5, .exact_hit = 1}, {kGround})},
      {"avoid", make(numbers::avoid<>{.magnitude = 1, .epsilon = 0.1, .look_ahead = 1}, {kBall})},
      {"sink", make(numbers::sink<>{.inside = 1}, {kNowhere})},
      {"sink_velocity", make(numbers::sink_velocity<>{.inside = 1}, {kNowhere})},
      {"jet", make(numbers::jet<>{}, {kHalf, kGust})},
      {"kill_old", make(numbers::kill_old<>{.age_limit = 1e6})},
      {"explosion",
       make(numbers::explosion<>{.center = {0, 25, 0}, .radius = 10, .magnitude = 1, .sigma = 5, .epsilon = 0.1})},
      {"vortex",
       make(numbers::vortex<>{
           .axis = {0, 50, 0}, .tightness = 1.5, .max_radius = 30, .in_speed = 1, .up_speed = 1, .around_speed = 1})},
      {"speed_clamp", make(numbers::speed_clamp<>{.max_speed = 1.5})},
      {"curl_noise", make(numbers::curl_noise<>{.strength = 1, .scale = 5, .octaves = 1})},
      {"restore", make(numbers::restore<>{.time_left = 100, .position = 1, .up = 1})},
      {"copy_vertex_b", make(numbers::copy_vertex_b<>{.position = 1})},
  };
  return all;
}

// Actions over the whole scene: a grid of 32 nodes along each axis; a zigzag path of 16 segments.
Action in_field() {
  actions::LookupTable table{{32, 32, 32}, 3, std::vector<float>(3 * 32 * 32 * 32, 0.5f)};
  Action action = make(numbers::field<>{.low = {-50, 0, -50}, .high = {50, 50, 50}, .strength = 1, .drag = -1});
  action.specifics = actions::Lookup{actions::keep(std::move(table))};
  return action;
}
Action along_path() {
  actions::LookupTable table{{16, 1, 1}, 8, {}};
  for (int i = 0; i < 16; ++i) {
    const float up = i % 2 == 0 ? 0.6f : -0.6f;
    const float row[8] = {
        -32 + 4 * static_cast<float>(i), i % 2 == 0 ? 0.0f : 3.0f, 0, 0.8f, up, 0, 5 * static_cast<float>(i), 5};
    table.values.insert(table.values.end(), row, row + 8);
  }
  Action action = make(numbers::follow_path<>{.speed = 1, .strength = 1, .look_ahead = 1, .radius = kInf});
  action.specifics = actions::Lookup{actions::keep(std::move(table))};
  return action;
}

// Returns a law: velocity.y changes by -9.81 m/s per second.
Action pull_down() {
  Action action = make(numbers::law<>{});
  action.specifics = actions::ParticleLaw{{{{actions::Op::constant, 0, -9.81f}}},
                                          {{actions::Result::How::rate, particles::velocity, 1}}};
  return action;
}

// Returns a `set`: mass = age * 2 + 1.
Action set_mass() {
  using actions::Op;
  Action action = make(numbers::set<>{});
  const actions::Expression twice_and_one = {{Op::column, particles::Schema()[particles::age].first_component, 0},
                                             {Op::constant, 0, 2},
                                             {Op::multiply},
                                             {Op::constant, 0, 1},
                                             {Op::add}};
  action.specifics = actions::Assignment{particles::mass, {twice_and_one}};
  return action;
}

// Returns an action of this kind with valid parameters. Kinds that usual() does not know get numbers of about 1.
Action example(Kind kind) {
  const actions::Facts& facts = actions::facts(kind);
  if (kind == Kind::set) return set_mass();
  if (kind == Kind::law) return pull_down();
  if (kind == Kind::field) return in_field();
  if (kind == Kind::follow_path) return along_path();
  Action action{kind, {}, {}};
  const auto known = usual().find(facts.name);
  if (known != usual().end()) {
    action = known->second;
  } else if (facts.ramp > 0) {
    for (const double ratio : {0.0, 0.3, 1.0}) {
      action.numbers.push_back(ratio);
      for (int c = 0; c < facts.ramp; ++c) action.numbers.push_back(1 - 0.5 * ratio);
    }
  } else {
    for (const actions::Number& number : facts.numbers) {
      for (int i = 0; i < number.count; ++i) {
        const double value = number.rule == actions::Number::Rule::axis && i != 1 ? 0 : 1;
        action.numbers.push_back(std::clamp(value, number.low, number.high));
      }
    }
    action.shapes.assign(static_cast<std::size_t>(facts.shapes), kGust);
  }
  actions::check(action);
  return action;
}

// A store that lists run over in turn.
struct Range {
  particles::Schema schema;
  Store store;
  std::uint64_t frame = 0;
  double dt = kDt;
  program::ListResult outcome;

  explicit Range(std::size_t particles, bool copies = false)
      : store(make(birth(particles), schema, {1, 2}, 0, particles, 0, copies)) {}

  // The lifetime has a column, but no particle reaches it.
  static Burst birth(std::size_t particles) {
    Burst air = full_air(particles);
    air.state.push_back({particles::lifetime, actions::distributions::Uniform{{1e3f}, {1e4f}}});
    return air;
  }

  // Returns nanoseconds per particle and sub-step. No particle leaves, but finding migrants costs as much as with a
  // domain.
  double run(const program::Program& program, int substeps) {
    const double start = cpu_now();
    outcome.clear();
    program.run(store, 0, 0, {frame++, substeps, dt * substeps, 0}, {1, 2}, program::Slice{0, -1e6f, 1e6f}, outcome);
    return 1e9 * (cpu_now() - start) / (static_cast<double>(store.size()) * substeps);
  }
  double limit(const Action& action) {
    const double start = cpu_now();
    touch(store, actions::reads(action, schema), actions::writes(action));
    return 1e9 * (cpu_now() - start) / static_cast<double>(store.size());
  }
};

// The move of the base list leaves orientations unchanged, so a list pays for them only where the action concerns them.
std::vector<Action> base_list() {
  std::vector<Action> list = paper_list("fountain");
  list.back() = make(numbers::move<>{.rotational = 0});
  return list;
}

program::Program with(std::vector<Action> list, const Action& action) {
  list.insert(list.end() - 1, action);
  return program::Program(std::move(list));
}

int bytes_of(std::uint64_t attributes, const particles::Schema& schema) {
  int bytes = 0;
  for (int a = 0; a < schema.size(); ++a) bytes += (attributes >> a & 1u) != 0 ? 4 * schema[a].width : 0;
  return bytes;
}

// sort is not a kernel: the store is sorted after the list has run.
double order_alone(Range& range, const Action& action, int repeats) {
  double least = kInf;
  for (int i = 0; i < repeats; ++i) {
    range.run(program::Program(base_list()), 1);
    const double start = cpu_now();
    program::order(action, 0, range.store);
    least = std::min(least, 1e9 * (cpu_now() - start) / static_cast<double>(range.store.size()));
  }
  return least;
}

// Alternates between the lists, since a shared machine is fast at one moment and slow at the next: only lists that run
// one after the other are compared, and the median of these comparisons counts.
void measure(Range& range, const program::Program& base, const Action& action, int repeats, int substeps, double& alone,
             double& added) {
  const program::Program only({action});
  const program::Program both = with(base_list(), action);
  range.run(only, 1);  // allocates the columns
  range.run(both, 1);
  double least = kInf;
  alone = kInf;
  std::vector<double> ratios;
  for (int i = 0; i < repeats; ++i) {
    const double without = range.run(base, substeps);
    ratios.push_back(range.run(both, substeps) / without);
    alone = std::min(alone, range.run(only, substeps));
    least = std::min(least, without);
  }
  added = least * (median(ratios) - 1);
}

}  // namespace

std::vector<ActionCost> action_bench(std::size_t particles, int repeats) {
  if (particles == 0) throw std::invalid_argument("particles must be at least 1, got 0");
  if (repeats < 1) throw std::invalid_argument("repeats must be at least 1, got " + std::to_string(repeats));
  const program::Program base(base_list());
  std::vector<ActionCost> costs;
  for (int k = 0; k < actions::kKinds; ++k) {
    if (actions::facts(static_cast<Kind>(k)).between) continue;  // see `bench meetings`
    const Action action = example(static_cast<Kind>(k));
    const bool copies = actions::uses_copies(action, {});
    const bool sorts = action.kind == Kind::sort;
    Range large(particles, copies), small(sorts ? kSorted : kCached, copies);
    ActionCost cost;
    cost.action = actions::facts(action.kind).name;
    if (sorts) {
      cost.alone = cost.added = order_alone(large, action, 1);
      cost.alone_in_cache = cost.added_in_cache = order_alone(small, action, repeats);
    } else {
      measure(large, base, action, 2 * repeats, 1, cost.alone, cost.added);
      measure(small, base, action, 64 * repeats, 64, cost.alone_in_cache, cost.added_in_cache);
    }
    cost.memory_limit = kInf;
    for (int i = 0; i < repeats; ++i) cost.memory_limit = std::min(cost.memory_limit, large.limit(action));
    const std::uint64_t reads = actions::reads(action, large.schema), writes = actions::writes(action);
    cost.bytes_loaded = bytes_of(reads | writes, large.schema);
    cost.bytes_stored = bytes_of(writes, large.schema);
    costs.push_back(cost);
  }
  return costs;
}

ListBench list_bench(std::size_t particles, int steps) {
  if (particles == 0 || steps < 1) throw std::invalid_argument("particles and steps must be at least 1");
  const std::vector<Action> five = paper_list("fountain");
  std::vector<Action> twelve = five;
  for (const Kind kind : {Kind::damping, Kind::speed_clamp, Kind::orbit_line, Kind::sink, Kind::sink_velocity,
                          Kind::orbit_point, Kind::target_velocity}) {
    twelve.insert(twelve.end() - 1, example(kind));
  }
  const auto without_draws = [](std::vector<Action> list) {
    std::erase_if(list, [](const Action& action) { return action.kind == Kind::random_acceleration; });
    return list;
  };
  const std::pair<const char*, program::Program> programs[] = {
      {"four_without_draws", program::Program(without_draws(five))},
      {"five", program::Program(five)},
      {"eleven_without_draws", program::Program(without_draws(twelve))},
      {"twelve", program::Program(twelve)}};
  constexpr std::size_t kLists = std::size(programs);
  constexpr int kSubsteps = 256;
  Range range(particles), cached(kCached);
  cached.dt = kDt / kSubsteps;
  const double seconds = static_cast<double>(range.store.size()) / 1e9;
  for (const auto& [name, program] : programs) {
    range.run(program, 1);
    cached.run(program, kSubsteps);
  }
  std::vector<double> limit, step_s[kLists], arithmetic[kLists], of_limit[kLists], of_roofline[kLists], ratios;
  for (int i = 0; i < steps; ++i) {
    const double start = cpu_now();
    touch(range.store, kStepped, kStepped);
    limit.push_back(cpu_now() - start);
    for (std::size_t p = 0; p < kLists; ++p) {
      step_s[p].push_back(range.run(programs[p].second, 1) * seconds);
      arithmetic[p].push_back(cached.run(programs[p].second, kSubsteps) * seconds);
      of_limit[p].push_back(limit.back() / step_s[p].back());
      of_roofline[p].push_back(std::max(limit.back(), arithmetic[p].back()) / step_s[p].back());
    }
    ratios.push_back(step_s[3].back() / step_s[1].back());
  }
  ListBench bench{{}, median(limit), median(ratios)};
  for (std::size_t p = 0; p < kLists; ++p) {
    bench.lists.push_back({.name = programs[p].first,
                           .seconds = median(step_s[p]),
                           .in_cache = median(arithmetic[p]),
                           .of_limit = median(of_limit[p]),
                           .of_roofline = median(of_roofline[p])});
  }
  return bench;
}

}  // namespace motes::bench
