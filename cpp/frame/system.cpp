#include "frame/system.h"

#include <algorithm>
#include <utility>

#include "simd/float_mode.h"

namespace motes::frame {

using recording::Birth;
using recording::Item;

System::System(recording::SystemDefinition given, std::uint64_t seed, std::uint32_t index, int calculators)
    : definition(std::move(given)), key(particles::system_key(seed, index)), sprite(definition.sprite) {
  for (const recording::UserAttribute& a : definition.attributes) schema.add(a.name, a.width, a.initial);
  store = std::make_unique<particles::Store>(schema);
  const domains::Space& space = definition.space;
  const bool finite = space.kind == domains::Space::Kind::finite;
  domains = domains::equal_slices(finite ? space.low : -domains::kInfinite, finite ? space.high : domains::kInfinite,
                                  calculators);
  waits_for_fit = space.kind == domains::Space::Kind::fit;
}

std::vector<BirthGroup> System::count_births(std::uint64_t frame, double dt, int substeps) {
  std::vector<BirthGroup> groups;
  for (int substep = 0; substep < substeps; ++substep) {
    const double from = (static_cast<double>(frame) + static_cast<double>(substep) / substeps) * dt;
    const double to = (static_cast<double>(frame) + static_cast<double>(substep + 1) / substeps) * dt;
    std::size_t entry = 0;
    for (std::size_t i = run_items; i < list.size(); ++i) {
      if (std::holds_alternative<actions::Action>(list[i])) ++entry;
      const auto* birth = std::get_if<Birth>(&list[i]);
      if (birth == nullptr || (substep > 0 && birth->kind != Birth::Kind::source)) continue;
      const std::uint64_t wanted = recording::births_between(*birth, from, to);
      const std::uint64_t taken = alive_at_start + born_this_frame;
      const std::uint64_t room = definition.capacity > taken ? definition.capacity - taken : 0;
      const std::uint64_t count = std::min(wanted, room);
      dropped += wanted - count;
      if (count == 0) continue;
      groups.push_back({i, entry, substep, born, count});
      if (!keeps_copies) history.add(*birth, born, count, static_cast<float>(dt / substeps));
      born += count;
      born_this_frame += count;
    }
  }
  return groups;
}

particles::Store System::make(const BirthGroup& group, std::uint64_t first, std::uint64_t count, double dt,
                              int substeps) const {
  const Birth& birth = std::get<Birth>(list[group.item]);
  return recording::make(birth, schema, key, group.first_id + first, count, static_cast<float>(dt / substeps),
                         keeps_copies, first);
}

void System::keep_copies() {
  if (keeps_copies) return;
  keeps_copies = true;
  const simd::FloatMode mode;
  history.restore_copies(*store, key);
}

std::vector<Piece> System::pending_pieces() const {
  std::vector<Piece> pieces;
  std::vector<actions::Action> actions;
  std::uint32_t before = 0;  // actions of earlier segments and pieces
  std::size_t first = 0;
  const auto cut = [&](const recording::Callback* callback) {
    const std::size_t length = actions.size();
    pieces.push_back({recording::Program(std::move(actions), before), first, callback});
    actions.clear();
    before += static_cast<std::uint32_t>(length);
    first += length;
  };
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (const auto* action = std::get_if<actions::Action>(&list[i])) {
      if (i < run_items) {
        ++before;
      } else {
        actions.push_back(*action);
      }
    } else if (const auto* callback = std::get_if<recording::Callback>(&list[i]); callback && i >= run_items) {
      cut(callback);
    }
  }
  if (!actions.empty() || pieces.empty()) cut(nullptr);
  return pieces;
}

std::vector<const recording::Spawn*> System::rules() const {
  std::vector<const recording::Spawn*> all;
  for (const Item& item : list) {
    if (const auto* spawn = std::get_if<recording::Spawn>(&item)) all.push_back(spawn);
  }
  return all;
}

void System::start_frame() {
  history.forget_dead(*store);
  list.clear();
  run_items = 0;
  born_this_frame = 0;
  alive_at_start = alive;
  moved = false;
  tally = {};
  tally.at_start = store->size();
  sent.clear();
  events.clear();
  const std::uint64_t room = definition.capacity > alive ? definition.capacity - alive : 0;
  children = {0, 0, 0, born, std::min(spawned, room)};
  dropped += spawned - children.count;
  born += children.count;
  born_this_frame += children.count;
  spawned = 0;
  offspring = std::exchange(next_offspring, {});
}

}  // namespace motes::frame
