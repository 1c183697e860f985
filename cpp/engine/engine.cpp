// The script's calls to the engine between two frames: systems, lists, reads.
#include "engine/engine.h"

#include <stdexcept>
#include <utility>

#include "base/fields.h"
#include "base/invalid_argument.h"
#include "engine/state/walls.h"
#include "interactions/kinds/tying.h"
#include "particles/wrap.h"

namespace motes::engine {
namespace {

bool ties(const actions::Action& action) { return std::holds_alternative<actions::TiedPairs>(action.specifics); }

void check_tie(const actions::Action& tie, const std::vector<recording::Item>& list) {
  interactions::check(tie);
  for (const recording::Item& item : list) {
    const auto* earlier = std::get_if<actions::Action>(&item);
    if (earlier != nullptr && ties(*earlier)) interactions::check_together(*earlier, tie);
  }
}

// Returns how a calculator measures its speed for the policy.
balance::SpeedOptions speed_options(const Rank& rank) {
  balance::SpeedOptions speeds;
  if (rank.settings.policy) speeds = rank.settings.policy->speeds;
  const double least = static_cast<double>(speeds.min_particles) / rank.settings.costs.messages.scale;
  speeds.min_particles = static_cast<std::uint64_t>(least);
  return speeds;
}

}  // namespace

Engine::Engine(std::unique_ptr<comm::Communicator> communicator, roles::Cast cast, Settings settings)
    : parts_(std::make_unique<Parts>(std::move(communicator), std::move(cast), std::move(settings))) {
  if (parts_->rank.settings.policy) parts_->rank.settings.policy->check(parts_->rank.session.calculators());
  parts_->rank.session.comm().weigh(parts_->rank.settings.costs.messages);
}

int Engine::add_system(recording::SystemDefinition definition) {
  const auto index = static_cast<std::uint32_t>(parts_->script.systems.size());
  const int calculators = static_cast<int>(parts_->rank.session.calculators());
  auto system = std::make_unique<System>(std::move(definition), parts_->rank.settings.seed, index, calculators);
  recording::check(system->outside.sprite, system->schema);
  if (const std::int32_t leader = system->definition.domains_of; leader >= 0) {
    const System& followed = *parts_->script.systems.at(static_cast<std::size_t>(leader));
    system->domains = followed.domains;
    system->waits_for_fit = followed.waits_for_fit;
  }
  auto here = std::make_unique<Population>(system->schema);
  here->speeds = balance::Speeds(1, speed_options(parts_->rank));
  parts_->script.systems.push_back(std::move(system));
  parts_->calculator.populations.push_back(std::move(here));
  parts_->manager.systems.emplace_back();
  return static_cast<int>(index);
}

void Engine::set_policy(balance::PolicyPtr policy) {
  policy->check(parts_->rank.session.calculators());
  parts_->rank.settings.policy = std::move(policy);
  for (const auto& here : parts_->calculator.populations)
    here->speeds = balance::Speeds(1, speed_options(parts_->rank));
}

void Engine::set_sprite(int index, const image::Sprite& sprite) {
  recording::check(sprite, system(index).schema);
  system(index).outside.sprite = sprite;
}

void Engine::record(int index, recording::Item item) {
  System& s = system(index);
  parts_->rank.session.comm().progress();  // lets messages of the last frame progress
  bool uses_copies = std::holds_alternative<recording::KeepCopies>(item);
  if (auto* action = std::get_if<actions::Action>(&item)) {
    actions::check(*action);
    actions::check(*action, s.schema);
    s.sweep(*action);
    if (ties(*action)) check_tie(*action, s.list);
    const std::int32_t other = action->partner ? action->partner->system : -1;
    if (other >= system_count() || other == index) {
      throw base::InvalidArgument("an action between particles", "name another system of the world");
    }
    if (action->partner && !interactions::law_of(*action).between_systems) {
      throw std::invalid_argument(actions::call_of(action->kind) + " acts only within one system");
    }
    uses_copies = actions::uses_copies(*action, s.schema);
  }
  if (const auto* birth = std::get_if<recording::Birth>(&item)) {
    recording::check(*birth, s.schema);
    uses_copies = recording::gives_copies(*birth);
  }
  if (const auto* spawn = std::get_if<recording::Spawn>(&item)) {
    if (spawn->into < 0 || spawn->into >= system_count())
      throw base::InvalidArgument("into", "be a system of this world");
    recording::check(*spawn, s.schema, system(spawn->into).schema);
    uses_copies = actions::uses_copies(spawn->where, s.schema);
    keep_copies(system(spawn->into),
                population(spawn->into));  // births of children cannot be recomputed from their ids
  }
  if (const auto* callback = std::get_if<recording::Callback>(&item)) {
    actions::check_condition(callback->where, callback->shapes, s.schema);
    uses_copies = actions::uses_copies(callback->where, s.schema);
  }
  if (uses_copies) keep_copies(s, population(index));
  s.list.push_back(std::move(item));
}

void Engine::record_interaction(int first, int second, actions::Action action, const actions::Action* counterpart) {
  if (first == second) throw base::InvalidArgument("other", "be another system");
  action.partner = {second};
  actions::Action mirrored = counterpart != nullptr ? *counterpart : action;
  record(first, std::move(action));
  mirrored.partner = {first, true};
  mirrored.where.clear();
  mirrored.shapes.clear();
  if (auto* grains = std::get_if<actions::Grains>(&mirrored.specifics)) grains->walls.clear();
  record(second, std::move(mirrored));
}

std::optional<std::array<double, 6>> Engine::wall_force(const shapes::Shape& wall) {
  catch_up();
  return force_on(parts_->script, wall, parts_->rank.settings.substeps);
}

std::pair<std::uint64_t, std::uint64_t> Engine::next_birth(int index) {
  catch_up();
  const Settings& settings = parts_->rank.settings;
  const System& system = *parts_->script.systems[static_cast<std::size_t>(index)];
  return system.next_birth(settings.dt, settings.substeps);
}

std::optional<ParticlesView> Engine::try_read(int index) {
  Rank& rank = parts_->rank;
  std::optional<ParticlesView> seen;
  rank.session.work("act", [&] { seen = read(rank, parts_->script, parts_->calculator, index); });
  pass_over(rank, system(index));
  return seen;
}

ParticlesView Engine::local(int index) {
  catch_up();
  check_readable(system(index));
  const std::optional<ParticlesView> seen = try_read(index);
  if (seen) return *seen;
  parts_->rank.session.rethrow();
  throw std::logic_error("nothing was read, and nothing failed");
}

void Engine::keep_preview(int index) {
  engine::keep_preview(parts_->rank, parts_->script, parts_->calculator, index);
  parts_->rank.session.rethrow();
}

void Engine::touched(int index) {
  Population& here = population(index);
  particles::wrap(here.store, pool());
  here.moved = true;
}

particles::Store& Engine::emptied(int index) {
  Population& here = population(index);
  here.store.clear();
  here.moved = false;
  return here.store;
}

void Engine::keep_lists(bool compute) {
  kept_.on = true;
  kept_.pictures = compute;
  kept_.only = !compute && parts_->rank.session.size() == 1;
}

base::Bytes Engine::shared_state() const {
  base::Bytes bytes;
  write(engine::shared_state(*parts_), bytes);
  return bytes;
}

void Engine::save_part(const std::string& path) {
  if (!parts_->rank.session.calculates()) return;
  base::Bytes& planes = writer_.planes();
  writer_.write(path, copy_part(planes));
}

void Engine::restore_state(std::span<const std::byte> state, const std::vector<Sample>& samples) {
  const SharedState shared = read_state(state);
  if (samples.size() != shared.systems.size()) throw std::invalid_argument("samples must be one per system");
  engine::restore_state(*parts_, shared, samples);
}

void Engine::Kept::keep(Script& script) {
  if (!on) return;
  lists.emplace_back();
  lists.back().put_raw(script.bytes.data(), script.bytes.size());
  if (!pictures) script.record.view.reset();
}

}  // namespace motes::engine
