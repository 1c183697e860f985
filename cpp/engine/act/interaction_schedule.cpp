#include "engine/act/interaction_schedule.h"

#include <algorithm>
#include <utility>

#include "engine/act/act.h"
#include "engine/act/interact.h"
#include "engine/act/run_list.h"
#include "engine/session/item_failure.h"
#include "interactions/extent.h"

namespace motes::engine {

using particles::Store;

namespace {

bool counts_contacts(const actions::Action& action) {
  return (actions::facts(action.kind).writes >> particles::contacts & 1u) != 0;
}

// Returns whether the segment ends with an interaction that counts contacts.
bool collides(const ListSegment& segment) {
  return segment.interaction != nullptr && counts_contacts(*segment.interaction);
}

}  // namespace

InteractionSchedule::InteractionSchedule(Rank& rank, const Script& script, Calculator& calculator, const Round& round)
    : rank_(rank), script_(script), calculator_(calculator), round_(round) {}

void InteractionSchedule::take_births(std::size_t index, Newborn& newborn) {
  const System& system = *script_.systems[index];
  Population& here = *calculator_.populations[index];
  begin_counts(here);
  here.outcome.gathers = false;  // the list runs in parts
  here.outcome.wants_hits = asks_for(system, recording::Spawn::On::collision);
  Runner& runner = runners_.emplace_back(Runner{index, system.pending_segments(), {}});
  runner.newborn_from = system.counts.newborn_from;
  for (const BirthGroup& group : system.groups) {
    of_item(system.list, index, group.item, [&] {
      Store births(system.schema);
      if (rank_.creates_in_place()) {
        create_own(rank_, system, group, births);
      } else {
        engine::take_births(rank_, system, group, newborn, births);
      }
      here.tally.created += births.size();
      runner.births.push_back(std::move(births));
    });
  }
}

void InteractionSchedule::run() {
  for (int substep = 0; substep < rank_.settings.substeps; ++substep) {
    if (!run_substep(substep)) return;
  }
}

void InteractionSchedule::start_substep() {
  for (Runner& runner : runners_) {
    runner.next_segment = 0;
    runner.collided = Collided::none;
    runner.laws = 0;
    calculator_.populations[runner.system]->collided.clear();
  }
}

// Runs the lists in turn, each until it has to wait for another. All ranks have the same lists, so they take the
// interactions in the same order, without a message about it.
bool InteractionSchedule::run_substep(int substep) {
  start_substep();
  for (bool done = false; !done;) {
    done = true;
    bool moved = false;
    for (Runner& runner : runners_) {
      while (const std::optional<Interaction> next = next_interaction(runner, substep)) {
        moved = true;
        if (!interact(rank_, script_, calculator_, round_, *next)) return false;
      }
      done = done && runner.reached == nullptr;
    }
    if (!moved && !done) throw std::logic_error("deadlock: systems wait for each other to interact");
  }
  return true;
}

// Runs a list to its next interaction and returns it; nothing at the end, or while the list of the other system has not
// come to the same interaction.
std::optional<Interaction> InteractionSchedule::next_interaction(Runner& runner, int substep) {
  if (runner.reached == nullptr) run_to_interaction(runner, substep);
  if (runner.reached == nullptr) return std::nullopt;
  Runner* first = &runner;
  Runner* second = &runner;
  if (runner.reached->partner) {
    second = &partner_of(runner);
    const actions::Action* const its = second->reached;
    if (its == nullptr || !its->partner || static_cast<std::size_t>(its->partner->system) != runner.system)
      return std::nullopt;
    if (runner.reached->second()) std::swap(first, second);
  }
  Interaction next = interaction_of(*first, *second, substep);
  first->reached = nullptr;
  second->reached = nullptr;
  return next;
}

interactions::SubStep InteractionSchedule::step_of(int substep) const {
  const Settings& settings = rank_.settings;
  const auto substeps = static_cast<std::uint64_t>(settings.substeps);
  return {
      .number = static_cast<std::uint32_t>(rank_.session.frame * substeps) + static_cast<std::uint32_t>(substep) + 1,
      .dt = static_cast<float>(settings.dt / settings.substeps),
      .time = program::time_of({rank_.session.frame, settings.substeps, settings.dt}, substep),
      .start = static_cast<float>(substep) / static_cast<float>(settings.substeps),
      .end = static_cast<float>(substep + 1) / static_cast<float>(settings.substeps),
      .last = substep + 1 == settings.substeps};
}

Interaction InteractionSchedule::interaction_of(Runner& first, Runner& second, int substep) const {
  Interaction interaction;
  interaction.item = first.segments[first.next_segment - 1].end;
  interactions::Meeting& meeting = interaction.meeting;
  meeting.count = &first == &second ? 1 : 2;
  meeting.step = step_of(substep);
  Runner* const runners[2] = {&first, &second};
  for (std::size_t s = 0; s < meeting.count; ++s) {
    Runner& runner = *runners[s];
    meeting.sides[s].system = runner.system;
    meeting.sides[s].action = runner.reached;
    if (interactions::remembers(*runner.reached)) meeting.sides[s].kept.law = runner.laws++;
    if (counts_contacts(*runner.reached)) describe_collision(runner, s, interaction);
  }
  return interaction;
}

// Notes what the action must know of the contacts that the sub-step has counted before, and what later ones must know.
void InteractionSchedule::describe_collision(Runner& runner, std::size_t side, Interaction& interaction) const {
  const System& system = *script_.systems[runner.system];
  interactions::Collisions& collisions = interaction.meeting.sides[side].collisions;
  collisions.gravity = system.gravity(runner.segments[runner.next_segment - 1].end);
  collisions.newborn_from = runner.newborn_from;
  interaction.collided[side] = runner.collided;
  const auto rest = runner.segments.begin() + static_cast<std::ptrdiff_t>(runner.next_segment);
  interaction.collides_again[side] = std::any_of(rest, runner.segments.end(), collides);
  const bool some = side == 0 && !runner.reached->where.empty() && runner.collided != Collided::all;
  runner.collided = some ? Collided::some : Collided::all;
  if (interactions::law_of(*runner.reached).clear == nullptr) return;  // the newborn stay newborn
  runner.newborn_from =
      runner.next_group < system.groups.size() ? system.groups[runner.next_group].first_id : system.counts.born;
}

InteractionSchedule::Runner& InteractionSchedule::partner_of(const Runner& runner) {
  const auto found = std::find_if(runners_.begin(), runners_.end(), [&](const Runner& other) {
    return other.system == static_cast<std::size_t>(runner.reached->partner->system);
  });
  if (found == runners_.end() || &*found == &runner)
    throw std::logic_error("two systems interact, but one has no list");
  return *found;
}

// Runs a list to its next interaction, or to the end.
void InteractionSchedule::run_to_interaction(Runner& runner, int substep) {
  while (runner.reached == nullptr && runner.next_segment < runner.segments.size()) {
    const ListSegment& segment = runner.segments[runner.next_segment++];
    rank_.session.work("act", [&] {
      calculator_.populations[runner.system]->tally.compute_s +=
          rank_.machine.timed([&] { run_segment(runner, segment, substep); });
    });
    runner.reached = segment.interaction;
  }
}

// Runs a segment on existing particles, and on particles born in it the part after their birth.
void InteractionSchedule::run_segment(Runner& runner, const ListSegment& segment, int substep) {
  const System& system = *script_.systems[runner.system];
  Population& here = *calculator_.populations[runner.system];
  const Settings& settings = rank_.settings;
  const program::Span span{rank_.session.frame, settings.substeps, settings.dt, substep, substep + 1};
  const program::Region everywhere;
  const auto run = [&](std::size_t begin, std::size_t skip) {
    segment.program.run(here.store, begin, skip, span, system.key, everywhere, here.outcome, *rank_.pool);
  };
  run(0, 0);
  std::size_t& g = runner.next_group;
  for (; g < system.groups.size() && system.groups[g].substep == substep && system.groups[g].item < segment.end; ++g) {
    const std::size_t begin = here.store.size();
    const Store& births = runner.births[g];
    here.store.append(births);
    run(begin, system.groups[g].entry - segment.first);
  }
  here.moved = true;
  if (segment.callback != nullptr) {
    call_back(calculator_, runner.system, *segment.callback, program::time_of(span, substep), 0);
  }
}

}  // namespace motes::engine
