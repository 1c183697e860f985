#include "engine/births/spawn.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>

#include "engine/session/item_failure.h"
#include "program/events.h"

namespace motes::engine {

namespace {

using recording::Event;
using recording::Spawn;

// Returns the particles that are new in this frame: the last frame's children and this frame's births, which have the
// highest ids. This takes a pass over all ids, so the result is empty if no rule needs them.
std::vector<std::uint32_t> newborn_of(const System& system, const particles::Store& store) {
  std::vector<std::uint32_t> newborn;
  if (!asks_for(system, Spawn::On::birth)) return newborn;
  for (std::size_t i = 0; i < store.size(); ++i) {
    if (store.ids()[i] >= system.counts.newborn_from) newborn.push_back(static_cast<std::uint32_t>(i));
  }
  return newborn;
}

// Notes the ids of particles that bounced, since interactions change indices.
void note_bounced(Population& here) {
  for (const std::uint32_t p : here.outcome.hits) here.bounced.insert(here.store.ids()[p]);
  here.outcome.hits.clear();
}

std::vector<std::uint32_t> bounced_of(const Population& here) {
  std::vector<std::uint32_t> bounced;
  for (std::size_t i = 0; !here.bounced.empty() && i < here.store.size(); ++i) {
    if (here.bounced.contains(here.store.ids()[i])) bounced.push_back(static_cast<std::uint32_t>(i));
  }
  return bounced;
}

// Returns the live particles; empty if no rule needs them.
std::vector<std::uint32_t> living_of(const System& system, const Population& here) {
  std::vector<std::uint32_t> living;
  if (!asks_for(system, Spawn::On::frame)) return living;
  std::vector<std::uint32_t> all(here.store.size());
  std::iota(all.begin(), all.end(), 0u);
  std::set_difference(all.begin(), all.end(), here.outcome.dead.begin(), here.outcome.dead.end(),
                      std::back_inserter(living));
  return living;
}

// Adds the events of each rule for the particles it applies to, sorted by id.
void add_events(const Rank& rank, const System& system, Population& here, const std::vector<std::uint32_t>& newborn,
                const std::vector<std::uint32_t>& dead, const std::vector<std::uint32_t>& bounced,
                const std::vector<std::uint32_t>& living) {
  const std::vector<const Spawn*> rules = system.rules();
  here.events.resize(rules.size());
  for (std::size_t r = 0; r < rules.size(); ++r) {
    const std::vector<std::uint32_t>& chosen = rules[r]->on == Spawn::On::birth   ? newborn
                                               : rules[r]->on == Spawn::On::death ? dead
                                               : rules[r]->on == Spawn::On::frame ? living
                                                                                  : bounced;
    std::vector<Event>& all = here.events[r];
    const auto old = static_cast<std::ptrdiff_t>(all.size());
    const std::vector<Event> more = program::events_of(*rules[r], rank.frame_time(), here.store, chosen);
    all.insert(all.end(), more.begin(), more.end());
    std::inplace_merge(all.begin(), all.begin() + old, all.end(),
                       [](const Event& a, const Event& b) { return a.id < b.id; });
  }
}

// Returns the calculators that own children of this event: the owner of its position, or of each child's id.
std::vector<int> owners_of_children(const System& system, const Event& event, std::uint64_t first_id,
                                    std::uint32_t count) {
  const std::array<float, 3> place{event.position[0], event.position[1], event.position[2]};
  if (!system.definition.axes.by_id()) return {system.domains.owner_of(place, first_id)};
  std::vector<int> owners;
  std::vector<bool> seen(static_cast<std::size_t>(system.domains.count()));
  for (std::uint64_t k = 0; k < count && owners.size() < seen.size(); ++k) {
    const auto owner = static_cast<std::size_t>(system.domains.owner_of(place, first_id + k));
    if (!seen[owner]) owners.push_back(static_cast<int>(owner));
    seen[owner] = true;
  }
  return owners;
}

bool same_rule(const Parent& a, const Parent& b) { return a.system == b.system && a.rule == b.rule; }

// Returns the index in a list of its spawn rule number `rule`.
std::size_t item_of_rule(const std::vector<recording::Item>& list, std::int32_t rule) {
  std::size_t item = 0;
  for (std::int32_t rules = 0; item < list.size(); ++item) {
    if (std::holds_alternative<Spawn>(list[item]) && rules++ == rule) break;
  }
  return item;
}

// Creates the children of parents begin .. end - 1, which all have the same rule.
void make_children(const Script& script, Calculator& calculator, int self, const std::vector<Parent>& parents,
                   std::size_t begin, std::size_t end, const std::vector<std::uint64_t>& children) {
  const System& from = *script.systems[static_cast<std::size_t>(parents[begin].system)];
  const Spawn& rule = *from.rules()[static_cast<std::size_t>(parents[begin].rule)];
  const auto into = static_cast<std::size_t>(rule.into);
  const System& system = *script.systems[into];
  std::vector<recording::Child> wanted;
  for (std::size_t p = begin; p < end; ++p) {
    const std::uint64_t count = children_of(parents[p].first, rule.count, children[into]);
    for (std::uint64_t k = 0; k < count; ++k) {
      const std::uint64_t id = system.counts.newborn_from + parents[p].first + k;
      const bool ours = !system.definition.axes.by_id() || system.domains.owner_of({}, id) == self;
      if (ours) wanted.push_back({id, &parents[p].event});
    }
  }
  const particles::Store newborn = recording::make(rule, wanted, system.schema, system.key, system.keeps_copies);
  Population& here = *calculator.populations[into];
  here.store.append(newborn);
  here.tally.created += newborn.size();
  if (!calculator.tail.children.empty()) calculator.tail.children[into] += particles::digest(newborn);
}

}  // namespace

void note_events(const Rank& rank, const System& system, Population& here) {
  if (here.bounced.empty()) {
    add_events(rank, system, here, newborn_of(system, here.store), here.outcome.dead, here.outcome.hits,
               living_of(system, here));
  } else {  // some bounced before an interaction
    note_bounced(here);
    add_events(rank, system, here, newborn_of(system, here.store), here.outcome.dead, bounced_of(here),
               living_of(system, here));
  }
}

void clear_dead(const Rank& rank, const System& system, Population& here) {
  program::ListResult& outcome = here.outcome;
  tidy(outcome);
  note_bounced(here);
  if (outcome.dead.empty()) return;
  const auto dead_ones = [&](const std::vector<std::uint32_t>& particles) {
    std::vector<std::uint32_t> dead;
    std::set_intersection(particles.begin(), particles.end(), outcome.dead.begin(), outcome.dead.end(),
                          std::back_inserter(dead));
    return dead;
  };
  if (!system.rules().empty()) {
    add_events(rank, system, here, dead_ones(newborn_of(system, here.store)), outcome.dead, dead_ones(bounced_of(here)),
               {});
  }
  for (const std::uint32_t p : outcome.dead) here.bounced.erase(here.store.ids()[p]);
  here.store.remove(outcome.dead, *rank.pool);
  here.tally.killed += outcome.dead.size();
  outcome.dead.clear();
  outcome.left.clear();
}

void collect_parents(const Rank& rank, const Script& script, Manager& manager, const Round& round,
                     const std::vector<SystemReport>& reports, Judgement& judgement) {
  if (round.first == 0) manager.parents.clear();
  if (!script.in_frame()) return;
  judgement.verdict.spawned.assign(script.systems.size(), 0);
  std::vector<std::uint64_t> next(script.systems.size(), 0);
  for (const PlacedParent& placed : manager.parents) next[static_cast<std::size_t>(placed.into)] += placed.count;
  for (std::size_t i = round.first; i < round.last; ++i) {
    const std::vector<const Spawn*> rules = script.systems[i]->rules();
    const auto& events = reports.at(i - round.first).events;
    for (std::size_t r = 0; r < rules.size() && r < events.size(); ++r) {
      const auto into = static_cast<std::size_t>(rules[r]->into);
      const System& system = *script.systems[into];
      for (const Event& event : events[r]) {
        const Parent parent{static_cast<std::int32_t>(i), static_cast<std::int32_t>(r), next[into], event};
        const std::uint64_t first_id = system.counts.born + next[into];
        const std::vector<int> owners = owners_of_children(system, event, first_id, rules[r]->count);
        for (const int owner : owners) judgement.parents.push_back({static_cast<std::uint32_t>(owner), parent});
        const int placed = system.definition.axes.by_id() ? -1 : owners[0];
        manager.parents.push_back({placed, rules[r]->into, rules[r]->count, first_id, parent});
        next[into] += rules[r]->count;
        judgement.verdict.spawned[into] += rules[r]->count;
      }
    }
  }
  const roles::Tree& tree = rank.session.relay().tree();
  std::stable_sort(judgement.parents.begin(), judgement.parents.end(), [&](const auto& a, const auto& b) {
    return tree.place_of(static_cast<int>(a.owner)) < tree.place_of(static_cast<int>(b.owner));
  });
}

void spawn(Rank& rank, Script& script, Calculator& calculator) {
  std::vector<std::uint64_t> spawned(script.systems.size(), 0);
  for (const Round& round : script.rounds) {
    for (std::size_t i = 0; i < round.verdict.spawned.size(); ++i) spawned[i] += round.verdict.spawned[i];
  }
  std::vector<std::uint64_t> children(script.systems.size());
  for (std::size_t i = 0; i < children.size(); ++i) children[i] = script.systems[i]->number_children(spawned[i]);
  calculator.tail.children.clear();
  if (rank.settings.log.digest) calculator.tail.children.assign(script.systems.size(), {});
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::create, "spawn");
  rank.session.work("spawn", [&] {
    for (const Round& round : script.rounds) {
      const std::vector<Parent>& parents = round.orders.parents;
      for (std::size_t begin = 0, end = 0; begin < parents.size(); begin = end) {
        while (end < parents.size() && same_rule(parents[end], parents[begin])) ++end;
        const auto from = static_cast<std::size_t>(parents[begin].system);
        const std::vector<recording::Item>& list = script.systems[from]->list;
        of_item(list, from, item_of_rule(list, parents[begin].rule),
                [&] { make_children(script, calculator, rank.session.calculator(), parents, begin, end, children); });
      }
    }
  });
}

}  // namespace motes::engine
