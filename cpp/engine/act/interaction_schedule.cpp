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

// Returns whether the segment ends with an interaction that counts contacts.
bool collides(const ListSegment& segment) {
  return segment.interaction != nullptr &&
         (segment.interaction->kind == actions::Kind::collide || actions::grains_of(*segment.interaction) != nullptr);
}

}  // namespace

InteractionSchedule::InteractionSchedule(Rank& rank, const Script& script, Calculator& calculator, const Round& round)
    : rank_(rank), script_(script), calculator_(calculator), round_(round) {}

void InteractionSchedule::take_births(std::size_t index, Newborn& newborn) {
  const System& system = *script_.systems[index];
  Population& here = *calculator_.populations[index];
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

// Runs the lists in turn. A list that reaches an interaction with another system waits until the other system's list
// gets there too.
bool InteractionSchedule::run_substep(int substep) {
  for (Runner& runner : runners_) {
    runner.next_segment = 0;
    runner.collided = Collided::none;
    runner.laws = 0;
    calculator_.populations[runner.system]->collided.clear();
  }
  std::vector<const ListSegment*> waits(runners_.size(), nullptr);
  for (std::size_t done = 0; done < runners_.size();) {
    done = 0;
    bool moved = false;
    for (std::size_t r = 0; r < runners_.size(); ++r) {
      Runner& runner = runners_[r];
      while (true) {
        if (waits[r] == nullptr) waits[r] = run_to_interaction(runner, substep);
        if (waits[r] == nullptr) break;
        std::size_t first = r;
        std::size_t second = r;
        if (waits[r]->interaction->partner) {
          const std::size_t other = partner_of(runner, *waits[r]);
          if (waits[other] == nullptr || !waits[other]->interaction->partner ||
              waits[other]->interaction->partner->system != static_cast<std::int32_t>(runner.system))
            break;
          (waits[r]->interaction->second() ? first : second) = other;
        }
        Interaction interaction = interaction_of(*waits[first], runners_[first], runners_[second], substep);
        if (first != second && actions::grains_of(*interaction.action) != nullptr)
          interaction.counterpart = waits[second]->interaction;
        waits[first] = nullptr;
        waits[second] = nullptr;
        moved = true;
        if (!interact(rank_, script_, calculator_, round_, interaction)) return false;
      }
      if (waits[r] == nullptr && runner.next_segment == runner.segments.size()) ++done;
    }
    if (!moved && done < runners_.size()) throw std::logic_error("deadlock: systems wait for each other to interact");
  }
  return true;
}

Interaction InteractionSchedule::interaction_of(const ListSegment& segment, Runner& first, Runner& second,
                                                int substep) const {
  Interaction interaction{.action = segment.interaction,
                          .item = segment.end,
                          .systems = {first.system, second.system},
                          .count = &first == &second ? 1u : 2u};
  const auto substeps = static_cast<std::uint64_t>(rank_.settings.substeps);
  interaction.substep =
      static_cast<std::uint32_t>(rank_.session.frame * substeps) + static_cast<std::uint32_t>(substep) + 1;
  interaction.time = program::time_of({rank_.session.frame, rank_.settings.substeps, rank_.settings.dt}, substep);
  interaction.start = static_cast<float>(substep) / static_cast<float>(rank_.settings.substeps);
  interaction.end = static_cast<float>(substep + 1) / static_cast<float>(rank_.settings.substeps);
  interaction.last = substep + 1 == rank_.settings.substeps;
  Runner* const runners[2] = {&first, &second};
  for (std::size_t side = 0; interactions::remembers(*segment.interaction) && side < interaction.count; ++side)
    interaction.law[side] = runners[side]->laws++;
  if (!collides(segment)) return interaction;
  for (std::size_t side = 0; side < interaction.count; ++side) {
    Runner& runner = *runners[side];
    const System& system = *script_.systems[runner.system];
    interaction.gravity[side] = system.gravity(runner.segments[runner.next_segment - 1].end);
    interaction.newborn_from[side] = runner.newborn_from;
    interaction.collided[side] = runner.collided;
    const auto rest = runner.segments.begin() + static_cast<std::ptrdiff_t>(runner.next_segment);
    interaction.collides_again[side] = std::any_of(rest, runner.segments.end(), collides);
    const bool some = side == 0 && !segment.interaction->where.empty() && runner.collided != Collided::all;
    runner.collided = some ? Collided::some : Collided::all;
    if (segment.interaction->kind != actions::Kind::collide) continue;
    runner.newborn_from =
        runner.next_group < system.groups.size() ? system.groups[runner.next_group].first_id : system.counts.born;
  }
  return interaction;
}

std::size_t InteractionSchedule::partner_of(const Runner& runner, const ListSegment& segment) const {
  const auto found = std::find_if(runners_.begin(), runners_.end(), [&](const Runner& other) {
    return other.system == static_cast<std::size_t>(segment.interaction->partner->system);
  });
  if (found == runners_.end() || &*found == &runner)
    throw std::logic_error("two systems interact, but one has no list");
  return static_cast<std::size_t>(found - runners_.begin());
}

const ListSegment* InteractionSchedule::run_to_interaction(Runner& runner, int substep) {
  while (runner.next_segment < runner.segments.size()) {
    const ListSegment& segment = runner.segments[runner.next_segment++];
    rank_.session.work("act", [&] {
      calculator_.populations[runner.system]->tally.compute_s +=
          rank_.machine.timed([&] { run_segment(runner, segment, substep); });
    });
    if (segment.interaction != nullptr) return &segment;
  }
  return nullptr;
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
