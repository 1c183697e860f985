#include "engine/parts/manager.h"

namespace motes::engine {

void say(Alarm&& alarm, std::uint64_t frame, Manager& manager) {
  if (Log* log = manager.account.log()) log->event(alarm.kind, frame, alarm.text);
  manager.remarks.push_back(std::move(alarm.text));
}

std::uint64_t children_of(std::uint64_t first, std::uint32_t count, std::uint64_t children) {
  return first >= children ? 0 : std::min<std::uint64_t>(count, children - first);
}

void note_children(const Script& script, const Manager& manager,
                   const std::function<void(std::size_t into, int calculator, std::uint64_t count)>& note) {
  std::vector<std::uint64_t> alive;
  for (const Round& round : script.rounds) {
    for (std::size_t i = round.first; i < round.last; ++i) alive.push_back(round.verdict.alive[i]);
  }
  for (const PlacedParent& placed : manager.parents) {
    const auto into = static_cast<std::size_t>(placed.into);
    const std::uint64_t capacity = script.systems[into]->definition.capacity;
    const std::uint64_t room = capacity > alive[into] ? capacity - alive[into] : 0;
    const std::uint64_t count = children_of(placed.parent.first, placed.count, room);
    for (std::uint64_t k = 0; placed.calculator < 0 && k < count; ++k) {
      note(into, script.systems[into]->domains.owner_of({}, placed.first_id + k), 1);
    }
    if (count > 0 && placed.calculator >= 0) note(into, placed.calculator, count);
  }
}

}  // namespace motes::engine
