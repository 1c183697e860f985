#include "engine/parts/snapshot.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/fields.h"
#include "domains/divide.h"
#include "meshes/assets.h"

namespace motes::engine {
namespace {

using domains::Domains;

[[noreturn]] void differs(const std::string& what) {
  throw std::runtime_error("the checkpoint belongs to a different world: " + what);
}

void check(const Settings& run, const Script& script, const SharedState& state) {
  if (state.seed != run.seed) differs("its seed is " + std::to_string(state.seed));
  if (state.dt != run.dt || state.substeps != run.substeps) {
    differs("its dt is " + std::to_string(state.dt) + ", its substeps " + std::to_string(state.substeps));
  }
  for (std::size_t i = 0; i < std::max(state.systems.size(), script.systems.size()); ++i) {
    if (i >= script.systems.size()) differs("it has a system '" + state.systems[i].name + "', which the script lacks");
    const recording::SystemDefinition& here = script.systems[i]->definition;
    if (i >= state.systems.size()) differs("it has no system '" + here.name + "'");
    const SharedSystem& then = state.systems[i];
    if (then.name != here.name) differs("its system '" + then.name + "' is '" + here.name + "' in the script");
    if (then.capacity != here.capacity) differs("its system '" + then.name + "' has a different capacity");
    if (then.attributes != here.attributes) differs("its system '" + then.name + "' has different attributes");
  }
}

// Returns the same domains if their number and axes are unchanged, otherwise domains that divide the sample equally.
Domains domains_for(const System& system, const SharedSystem& then, const Sample& sample, int calculators) {
  const domains::Axes axes = system.definition.axes;
  const std::shared_ptr<const domains::Curve>& curve = system.domains.curve();
  if (then.axes == axes && then.cuts.size() + 1 == static_cast<std::size_t>(calculators)) {
    return Domains::of(then.cuts, curve);
  }
  domains::Places places;
  places.count = sample[0].size();
  for (std::size_t axis = 0; axis < sample.size(); ++axis) places.position[axis] = sample[axis].data();
  if (places.count == 0) return system.domains;
  return curve ? domains::quantiles(curve, places, calculators) : domains::quantiles(axes, places, calculators);
}

const snapshots::SavedPlane* plane_of_position(const snapshots::Description& description, std::size_t system,
                                               int component) {
  const std::string name = particles::kBuiltins[particles::position].name;
  for (const snapshots::SavedPlane& plane : description.planes) {
    if (plane.system != static_cast<std::int32_t>(system) || plane.attribute != name) continue;
    if (plane.kind == snapshots::Plane::uniform || plane.component == component) return &plane;
  }
  return nullptr;
}

}  // namespace

SharedState shared_state(const Parts& parts) {
  const Settings& run = parts.rank.settings;
  const Script& script = parts.script;
  SharedState state;
  state.frame = parts.rank.session.frame;
  state.seed = run.seed;
  state.dt = run.dt;
  state.substeps = run.substeps;
  state.camera = script.camera;
  state.camera_frame = script.camera_frame;
  state.camera_before = script.camera_before;
  state.walls = script.walls;
  for (const auto& system : script.systems) {
    const recording::SystemDefinition& definition = system->definition;
    std::optional<image::Sprite> changed;
    if (system->outside.sprite != definition.sprite) changed = system->outside.sprite;
    state.systems.push_back({definition.name, definition.capacity, definition.attributes, system->counts,
                             system->sources, system->keeps_copies, system->history, system->walls_before,
                             definition.axes, system->domains.tree(), std::move(changed)});
  }
  if (parts.rank.session.manages()) {
    for (const Balancing& system : parts.manager.systems) state.manager.evaluations.push_back(system.evaluations);
    state.manager.alarms = parts.manager.alarms;
  }
  return state;
}

// Meshes and pictures come first, because reading the shapes in histories, sprites and walls looks them up.
void write(const SharedState& state, base::Bytes& out) {
  std::set<meshes::AssetKey> meshes;
  const auto add = [&](const shapes::Shape& shape) {
    for (const meshes::AssetKey key : shapes::meshes_of(shape)) meshes.insert(key);
  };
  for (const SharedSystem& system : state.systems) {
    for (const meshes::AssetKey key : system.history.meshes()) meshes.insert(key);
    std::for_each(system.walls.begin(), system.walls.end(), add);
    if (const std::optional<image::Sprite>& sprite = system.sprite; sprite.has_value()) {
      meshes.insert({sprite->asset(), sprite->picture_on_mesh()});
      const image::Sheet* sheet = sprite->sheet();
      if (sheet != nullptr) std::for_each(sheet->pick.shapes.begin(), sheet->pick.shapes.end(), add);
    }
  }
  for (const PressedWall& wall : state.walls) add(wall.shape);
  meshes.erase(0);
  meshes::write_assets(meshes, out);
  base::write_fields(state, out);
}

SharedState read_state(std::span<const std::byte> bytes) {
  base::Reader in(bytes);
  meshes::read_assets(in);
  SharedState state;
  base::read_fields(in, state);
  if (!in.done()) throw std::runtime_error("damaged checkpoint: there is data after the state of the world");
  return state;
}

snapshots::Description copy_part(const Rank& rank, const Script& script, const Calculator& calculator,
                                 base::Bytes& out) {
  snapshots::Description description;
  description.frame = rank.session.frame;
  description.part = rank.session.calculator();
  std::vector<const particles::Store*> stores;
  for (std::size_t i = 0; i < script.systems.size(); ++i) {
    description.systems.push_back({script.systems[i]->definition.name, 0});
    stores.push_back(&calculator.populations[i]->store);
    base::write_fields(calculator.populations[i]->speeds, description.more);
  }
  snapshots::copy(stores, description, out, *rank.pool);
  return description;
}

void take_sample(const snapshots::Description& description, std::span<const std::byte> planes, std::size_t system,
                 std::size_t most, Sample& sample) {
  const std::uint64_t rows = description.systems.at(system).rows;
  if (rows == 0 || most == 0) return;
  const std::uint64_t step = std::max<std::uint64_t>(1, rows / most);
  for (int c = 0; c < 3; ++c) {
    const snapshots::SavedPlane* plane = plane_of_position(description, system, c);
    if (plane == nullptr) throw std::runtime_error("damaged checkpoint: particles without positions");
    const bool shared = plane->kind == snapshots::Plane::uniform;
    for (std::uint64_t row = 0; row < rows; row += step) {
      const std::uint64_t index = shared ? static_cast<std::uint64_t>(c) : row;
      float value = 0;
      std::memcpy(&value, planes.subspan(plane->offset + index * sizeof value, sizeof value).data(), sizeof value);
      sample[static_cast<std::size_t>(c)].push_back(value);
    }
  }
}

void restore_state(Parts& parts, const SharedState& state, const std::vector<Sample>& samples) {
  Rank& rank = parts.rank;
  Script& script = parts.script;
  Calculator& calculator = parts.calculator;
  check(rank.settings, script, state);
  // A world that has run goes back to an earlier frame.
  calculator.neighbours.clear();
  calculator.ghosts.clear();
  script.new_cuts.clear();
  const int calculators = static_cast<int>(rank.session.calculators());
  for (std::size_t i = 0; i < script.systems.size(); ++i) {
    System& system = *script.systems[i];
    const SharedSystem& then = state.systems[i];
    system.counts = then.counts;
    system.sources = then.sources;
    system.keeps_copies = then.keeps_copies;
    system.history = then.history;
    if (then.sprite) system.outside.sprite = *then.sprite;
    if (system.definition.domains_of < 0 && then.counts.born > 0) {
      script.divide(i, domains_for(system, then, samples[i], calculators));
    }
    system.start_frame();
    system.walls_before = then.walls;
    calculator.populations[i]->store.clear();
    start_frame(*calculator.populations[i]);
  }
  script.camera = state.camera;
  script.camera_frame = state.camera_frame;
  script.camera_before = state.camera_before;
  script.walls = state.walls;
  rank.session.frame = state.frame;
  if (!rank.session.manages()) return;
  std::vector<Balancing>& balancing = parts.manager.systems;
  for (std::size_t i = 0; i < std::min(balancing.size(), state.manager.evaluations.size()); ++i) {
    balancing[i].evaluations = state.manager.evaluations[i];
  }
  parts.manager.alarms = state.manager.alarms;
}

void restore_rows(const Rank& rank, const Calculator& calculator, const snapshots::Description& description,
                  std::span<const std::byte> planes, std::size_t system, std::uint64_t first, std::uint64_t last) {
  Population& here = *calculator.populations.at(system);
  snapshots::append(description, planes, system, first, last, here.store, *rank.pool);
  here.tally.at_start = here.store.size();
  here.moved = true;  // any particle may belong to another calculator
}

void restore_speeds(const Calculator& calculator, const snapshots::Description& description) {
  base::Reader in(description.more.view());
  for (const auto& here : calculator.populations) base::read_fields(in, here->speeds);
}

}  // namespace motes::engine
