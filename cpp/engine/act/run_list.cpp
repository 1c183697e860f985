#include "engine/act/run_list.h"

#include <algorithm>

#include "engine/state/places.h"
#include "program/order.h"

namespace motes::engine {

namespace {

using program::ListResult;

constexpr std::size_t kRange = std::size_t{1} << 14;  // particles per task of a thread

// Finds the particles that other calculators own, by looking up the owner of each.
void find_others(const Rank& rank, const System& system, Population& here) {
  std::vector<std::uint32_t> owners(here.store.size());
  const domains::Places places = places_of(here.store);
  threads::over_ranges(*rank.pool, owners.size(), kRange, [&](std::size_t first, std::size_t last) {
    system.domains.owners_of(places, first, last, owners.data());
  });
  const auto self = static_cast<std::uint32_t>(rank.session.calculator());
  for (std::uint32_t p = 0; p < owners.size(); ++p) {
    if (owners[p] != self) here.outcome.left.push_back(p);
  }
}

// Callbacks need particles that have run exactly as far as the script's calls say, so such a list cannot be fused.
bool calls_back(const std::vector<ListSegment>& segments) {
  return segments.size() > 1 || segments[0].callback != nullptr;
}

// Runs the list in one pass, or segment by segment in each sub-step if there are callbacks between segments, on
// particles from `begin` on. `newborn`: the group that they belong to; null: existing particles.
void run_segments(const Rank& rank, const System& system, Population& here, const std::vector<ListSegment>& segments,
                  const CallBack& call_back, std::size_t begin, const BirthGroup* newborn) {
  particles::Store& store = here.store;
  const Settings& run = rank.settings;
  const int born = newborn != nullptr ? newborn->substep : 0;
  const std::size_t entry = newborn != nullptr ? newborn->entry : 0;
  program::Span span{rank.session.frame, run.substeps, run.dt, born, 0};
  if (!calls_back(segments)) {
    segments[0].program.run(store, begin, entry, span, system.key, region_of(rank, system), here.outcome, *rank.pool);
    return;
  }
  if (begin >= store.size()) return;
  const program::Region everywhere;
  for (int substep = born; substep < run.substeps; ++substep) {
    span.first = substep;
    span.last = substep + 1;
    const bool in_birth = newborn != nullptr && substep == born;
    const std::size_t from = in_birth ? entry : 0;
    for (const ListSegment& segment : segments) {
      const std::size_t skip = std::min(from > segment.first ? from - segment.first : 0, segment.program.size());
      segment.program.run(store, begin, skip, span, system.key, everywhere, here.outcome, *rank.pool);
      if (segment.callback != nullptr && !(in_birth && newborn->item > segment.end))
        call_back(*segment.callback, program::time_of(span, substep), begin);
    }
  }
}

}  // namespace

program::Region region_of(const Rank& rank, const System& system) {
  const domains::Box box = system.domains.box(rank.session.calculator());
  program::Region region;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (system.definition.axes.has(axis)) region.limit({axis, box.low[i], box.high[i]});
  }
  return region;
}

void find_migrants(const Rank& rank, const System& system, Population& here) {
  here.outcome.left.clear();
  const domains::Axes axes = system.definition.axes;
  if (axes.curve()) {
    if (rank.session.calculators() > 1) find_others(rank, system, here);
  } else if (axes.by_id()) {
    if (here.moved) find_others(rank, system, here);  // ids never change, so only new cuts make migrants
  } else {
    program::Program::find_migrants(here.store, 0, region_of(rank, system), here.outcome, *rank.pool);
  }
  tidy(here.outcome);
}

std::map<int, std::vector<std::uint32_t>> migrants_by_owner(const Rank& rank, const System& system,
                                                            const Population& here) {
  std::map<int, std::vector<std::uint32_t>> to;
  const domains::Places places = places_of(here.store);
  for (const std::uint32_t p : here.outcome.left) {
    const int owner = owner_of(system.domains, places, p);
    if (owner != rank.session.calculator()) to[owner].push_back(p);
  }
  return to;
}

void run_list(const Rank& rank, const System& system, Population& here, const Append& append, const CallBack& call_back,
              bool keep_hits) {
  begin_counts(here);
  const std::vector<ListSegment> segments = system.pending_segments();
  const bool again = !here.outcome.dead.empty() || !here.outcome.hits.empty();  // a part of the list has run before
  here.outcome.wants_hits = keep_hits || asks_for(system, recording::Spawn::On::collision);
  here.outcome.gathers = !again && !calls_back(segments) && !here.outcome.wants_hits;
  run_segments(rank, system, here, segments, call_back, 0, nullptr);
  for (const BirthGroup& group : system.groups) {
    const std::size_t begin = here.store.size();
    append(group);
    here.tally.created += here.store.size() - begin;
    run_segments(rank, system, here, segments, call_back, begin, &group);
  }
  if (calls_back(segments) || system.definition.axes.curve()) {
    find_migrants(rank, system, here);
  } else if (again) {
    tidy(here.outcome);
  }
}

void sort(const Rank& rank, const System& system, particles::Store& store, std::size_t first) {
  for (const actions::Action* action : system.sorts(first))
    program::order(*action, rank.frame_time(), store, *rank.pool);
}

}  // namespace motes::engine
