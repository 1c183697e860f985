#include "engine/state/system.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/invalid_argument.h"
#include "base/vectors.h"
#include "domains/divide.h"

namespace motes::engine {

using recording::Birth;
using recording::Item;

System::System(recording::SystemDefinition given, std::uint64_t seed, std::uint32_t index, int calculators)
    : definition(std::move(given)), schema(recording::schema_of(definition)), key(particles::system_key(seed, index)),
      outside{definition.sprite, 0} {
  const domains::Space& space = definition.space;
  if (definition.axes.curve() && !domains::has_ends(space, definition.periods)) {
    throw base::InvalidArgument("space", "be bounded on all sides if its domains follow a curve", "", definition.name);
  }
  domains = domains::equal_parts(definition.axes, domains::room_of(space, definition.periods), calculators);
  waits_for_fit = space.kind == domains::Space::Kind::fit && !definition.axes.by_id() && !definition.axes.curve();
}

void System::count_births(double dt, int substeps) {
  groups.clear();
  const std::vector<recording::SourceTotal*> totals = recording::totals_of(list, sources);
  for (int substep = 0; substep < substeps; ++substep) {
    std::size_t entry = 0;
    for (std::size_t i = run_items; i < list.size(); ++i) {
      if (std::holds_alternative<actions::Action>(list[i])) ++entry;
      const auto* birth = std::get_if<Birth>(&list[i]);
      if (birth == nullptr) continue;
      const std::uint64_t wanted = recording::births_in_step(*birth, dt, substep, substeps, totals[i]);
      const std::uint64_t taken = counts.alive_at_start + counts.born - counts.born_at_start;
      const std::uint64_t room = room_of(taken);
      const std::uint64_t count = std::min(wanted, room);
      counts.dropped += wanted - count;
      if (count == 0) continue;
      groups.push_back({i, entry, substep, counts.born, count});
      const float step = static_cast<float>(dt / substeps);
      if (!keeps_copies) history.add(*birth, counts.born, count, recording::moment_of(*birth, step, substep, substeps));
      counts.born += count;
    }
  }
}

std::pair<std::uint64_t, std::uint64_t> System::next_birth(double dt, int substeps) const {
  std::vector<recording::SourceTotal> after = sources;
  const std::vector<recording::SourceTotal*> totals = recording::totals_of(list, after);
  std::uint64_t born = 0;
  std::uint64_t room = room_of(counts.alive_at_start + counts.born - counts.born_at_start);
  for (std::size_t i = run_items; i < list.size(); ++i) {
    const auto* birth = std::get_if<Birth>(&list[i]);
    if (birth == nullptr) continue;
    const std::uint64_t count = std::min(recording::births_in_step(*birth, dt, 0, substeps, totals[i]), room);
    born += count;
    room -= count;
  }
  return {counts.born + born, room};
}

particles::Store System::make(const BirthGroup& group, std::uint64_t first, std::uint64_t count, double dt,
                              int substeps) const {
  std::vector<std::uint64_t> ids(count);
  std::iota(ids.begin(), ids.end(), group.first_id + first);
  return make(group, ids, dt, substeps);
}

particles::Store System::make(const BirthGroup& group, std::span<const std::uint32_t> numbers, double dt,
                              int substeps) const {
  std::vector<std::uint64_t> ids(numbers.size());
  std::transform(numbers.begin(), numbers.end(), ids.begin(),
                 [&](std::uint32_t number) { return group.first_id + number; });
  return make(group, ids, dt, substeps);
}

particles::Store System::make(const BirthGroup& group, const std::vector<std::uint64_t>& ids, double dt,
                              int substeps) const {
  const Birth& birth = std::get<Birth>(list[group.item]);
  const recording::BirthStep moment =
      recording::moment_of(birth, static_cast<float>(dt / substeps), group.substep, substeps);
  return recording::make(birth, schema, key, ids, moment, keeps_copies, group.first_id);
}

std::vector<ListSegment> System::pending_segments() const {
  std::vector<ListSegment> segments;
  std::vector<actions::Action> actions;
  std::uint32_t before = 0;  // actions of earlier segments
  std::size_t first = 0;
  const auto cut = [&](std::size_t end, const recording::Callback* callback, const actions::Action* interaction) {
    const std::size_t length = actions.size();
    segments.push_back({program::Program(std::move(actions), before, schema), first, end, callback, interaction});
    actions.clear();
    before += static_cast<std::uint32_t>(length + (interaction != nullptr ? 1 : 0));
    first += length + (interaction != nullptr ? 1 : 0);
  };
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (const auto* action = std::get_if<actions::Action>(&list[i])) {
      if (i < run_items) {
        ++before;
      } else if (actions::facts(action->kind).between) {
        cut(i, nullptr, action);
      } else {
        actions.push_back(*action);
      }
    } else if (const auto* callback = std::get_if<recording::Callback>(&list[i]); callback && i >= run_items) {
      cut(i, callback, nullptr);
    }
  }
  if (!actions.empty() || segments.empty() || segments.back().interaction != nullptr)
    cut(list.size(), nullptr, nullptr);
  return segments;
}

bool System::interacts() const {
  return std::any_of(list.begin() + static_cast<std::ptrdiff_t>(run_items), list.end(), [](const Item& item) {
    const auto* action = std::get_if<actions::Action>(&item);
    return action != nullptr && actions::facts(action->kind).between;
  });
}

std::vector<const recording::Spawn*> System::rules() const {
  std::vector<const recording::Spawn*> all;
  for (const Item& item : list) {
    if (const auto* spawn = std::get_if<recording::Spawn>(&item)) all.push_back(spawn);
  }
  return all;
}

std::vector<const actions::Action*> System::sorts(std::size_t first) const {
  std::vector<const actions::Action*> all;
  for (std::size_t i = first; i < list.size(); ++i) {
    const auto* action = std::get_if<actions::Action>(&list[i]);
    if (action != nullptr && action->kind == actions::Kind::sort) all.push_back(action);
  }
  return all;
}

double System::gravity(std::size_t end) const {
  Vector sum{};
  for (std::size_t i = 0; i < end; ++i) {
    const auto* action = std::get_if<actions::Action>(&list[i]);
    if (action == nullptr || action->kind != actions::Kind::gravity) continue;
    const auto [pull] = actions::numbers_of<actions::numbers::gravity>(*action);
    sum = sum + Vector{pull[0], pull[1], pull[2]};
  }
  return length(sum);
}

std::uint64_t System::number_children(std::uint64_t spawned) {
  counts.newborn_from = counts.born;
  const std::uint64_t room = room_of(counts.alive);
  const std::uint64_t count = std::min(spawned, room);
  counts.dropped += spawned - count;
  counts.born += count;
  counts.alive += count;
  return count;
}

void System::start_frame() {
  walls_before = std::exchange(walls, {});
  list.clear();
  run_items = 0;
  groups.clear();
  counts.born_at_start = counts.born;
  counts.alive_at_start = counts.alive;
}

void System::sweep(actions::Action& action) {
  using actions::Kind;
  const bool swept = action.kind == Kind::bounce || action.kind == Kind::bounce_counted || action.kind == Kind::contact;
  if (!swept) return;
  for (shapes::Shape& wall : action.shapes) {
    if (wall.kind != shapes::Kind::mesh) continue;
    const auto same = [&](const shapes::Shape& other) { return other.origin == wall.origin; };
    auto turn = std::count_if(walls.begin(), walls.end(), same);
    walls.push_back(wall);
    walls.back().before = 0;  // where it was before does not matter to the next frame
    if (wall.before != 0) continue;  // the script says from where
    const auto before = std::find_if(walls_before.begin(), walls_before.end(),
                                     [&](const shapes::Shape& other) { return same(other) && turn-- == 0; });
    if (before != walls_before.end() && before->mesh != wall.mesh) shapes::deform_from(wall, *before);
  }
}

bool asks_for(const System& system, recording::Spawn::On event) {
  const std::vector<const recording::Spawn*> rules = system.rules();
  return std::any_of(rules.begin(), rules.end(), [&](const recording::Spawn* rule) { return rule->on == event; });
}

}  // namespace motes::engine
