#include "engine/act/act.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <span>

#include "balance/cuts.h"

#include "engine/act/interact.h"
#include "engine/act/interaction_schedule.h"
#include "engine/act/motion.h"
#include "engine/act/run_list.h"
#include "engine/births/spawn.h"
#include "engine/session/item_failure.h"
#include "particles/trace.h"
#include "particles/wrap.h"
#include "program/select.h"

namespace motes::engine {

namespace {

using particles::Store;

// Charges the cost of the list for every particle it ran over, including the dead and migrants.
void charge_list(const Rank& rank, const System& system, const Population& here) {
  const Costs& costs = rank.machine.costs();
  const auto newborn = static_cast<double>(here.tally.created);
  const double all = static_cast<double>(here.tally.at_start) + newborn;
  rank.machine.charge(costs.newborn * newborn + costs.of(system.list) * all * rank.settings.substeps);
}

std::uint64_t lowest_id(const Store& store) {
  const particles::Ids ids = store.ids();
  std::uint64_t lowest = UINT64_MAX;
  for (std::size_t i = 0; i < store.size(); ++i) lowest = std::min(lowest, ids[i]);
  return lowest;
}

// Completes a run of the list: keeps traces, finds migrants and events, and charges the cost.
void end_list(const Rank& rank, const System& system, Population& here) {
  if (const auto* ribbon = system.outside.sprite.as<image::RibbonSprite>()) {
    const auto times = particles::TraceTimes::over(ribbon->length, rank.settings.dt, rank.session.frame);
    particles::keep_trace(here.store, times, *rank.pool);
  }
  if (here.moved && here.outcome.left.empty())
    find_migrants(rank, system, here);  // a list without actions has not looked for migrants
  here.tally.killed += here.outcome.dead.size();
  note_events(rank, system, here);
  here.oldest = system.asks_oldest ? lowest_id(here.store) : UINT64_MAX;
  charge_list(rank, system, here);
}

void act_on(Rank& rank, const System& system, std::size_t index, Population& here, Newborn& newborn,
            const CallBack& call_back) {
  const auto append = [&](const BirthGroup& group) {
    of_item(system.list, index, group.item, [&] {
      if (rank.creates_in_place()) {
        create_own(rank, system, group, here.store);
      } else {
        take_births(rank, system, group, newborn, here.store);
      }
    });
  };
  const Motion motion(rank, system, here);
  here.tally.compute_s += rank.machine.timed([&] {
    run_list(rank, system, here, append, call_back, false);
    end_list(rank, system, here);
  });
  motion.measure(here);
}

// For the log of a calculator that had no migrants yet, or was asked for no cut: handles a few particles on trial, so
// that a replay of the log knows the costs. Takes less than a hundredth of a frame, in frames 1, 2, 4, 8, ...
void try_handling(const Rank& rank, const System& system, Population& here) {
  Handling& handling = here.handling;
  const std::size_t n = here.store.size();
  const bool known = handling.pack.particles > 0 && handling.unpack.particles > 0 && handling.search.particles > 0 &&
                     !std::isnan(handling.bytes);
  if (rank.settings.log.directory.empty() || n < 2 || known || !std::has_single_bit(rank.session.frame)) return;
  const Costs& costs = rank.machine.costs();
  const auto timed = [&](Handling::Work& work, std::size_t count, double cost, const auto& run) {
    const double start = rank.machine.compute_seconds();
    run();
    rank.machine.charge(cost * static_cast<double>(count));
    work.add(count, rank.machine.compute_seconds() - start);
  };
  const std::size_t few = 1 + (n + 2047) / 2048, some = (n + 255) / 256;
  base::Bytes one, bytes;
  here.store.pack(first_indices(1), one, *rank.pool);
  timed(handling.pack, few, costs.leave, [&] { here.store.pack(first_indices(few), bytes, *rank.pool); });
  handling.bytes = static_cast<float>(bytes.size() - one.size()) / static_cast<float>(few - 1);
  timed(handling.unpack, few, costs.arrive, [&] {
    Store copies(here.store.schema());
    base::Reader in(bytes.view());
    copies.unpack(in, *rank.pool);
  });
  if (system.definition.axes.first() >= domains::kById) return;
  const std::span<const float> x(here.store.plane(particles::position, system.definition.axes.first()), some);
  timed(handling.search, some, costs.select,
        [&] { balance::histogram(x, 1); });  // more bins: a sort that does not grow with x
}

// Removes the dead, and packs the migrants for their owners and removes them.
void pack_migrants(const Rank& rank, const System& system, Population& here, Round& round, std::uint32_t index) {
  Store& store = here.store;
  if (rank.settings.log.digest) {
    here.digest = particles::digest(store, *rank.pool);
    here.digest -= particles::digest(store, here.outcome.dead);
  }
  const double start = rank.machine.compute_seconds();
  std::vector<std::uint32_t> gone;
  for (const auto& [owner, migrants] : migrants_by_owner(rank, system, here)) {
    base::Bytes& bytes = round.leaving[owner].bytes();
    const std::size_t before = bytes.size();
    bytes.put(index);
    store.pack(migrants, bytes, *rank.pool);
    here.sent.push_back({owner, migrants.size()});
    here.tally.bytes_sent += bytes.size() - before;
    gone.insert(gone.end(), migrants.begin(), migrants.end());
  }
  std::sort(gone.begin(), gone.end());
  here.tally.sent = gone.size();
  const Costs& costs = rank.machine.costs();
  const double among = costs.gap * static_cast<double>(store.size()) * costs.messages.scale;
  rank.machine.charge((costs.leave + among) * static_cast<double>(gone.size()));
  std::vector<std::uint32_t> all;
  all.reserve(gone.size() + here.outcome.dead.size());
  std::merge(gone.begin(), gone.end(), here.outcome.dead.begin(), here.outcome.dead.end(), std::back_inserter(all));
  store.remove(all, *rank.pool);
  here.outcome.clear();
  if (!gone.empty()) here.handling.pack.add(gone.size(), rank.machine.compute_seconds() - start);
  try_handling(rank, system, here);
}

// Runs the lists of systems without interactions; of the other systems, takes the births.
void act_on_all(Rank& rank, const Script& script, const Calculator& calculator, Round& round, Newborn& newborn,
                InteractionSchedule& course) {
  std::uint64_t received = 0;
  for (std::size_t i = round.first; i < round.last; ++i) {
    const System& system = *script.systems[i];
    Population& here = *calculator.populations[i];
    const std::uint64_t before = here.tally.created;
    if (system.interacts()) {
      course.take_births(i, newborn);
    } else {
      act_on(rank, system, i, here, newborn, [&](const recording::Callback& callback, double time, std::size_t begin) {
        call_back(calculator, i, callback, time, begin);
      });
      pack_migrants(rank, system, here, round, static_cast<std::uint32_t>(i));
    }
    received += here.tally.created - before;
  }
  if (received != newborn.count) throw std::runtime_error("births were lost on the way");
}

// Ends the lists with interactions. They ended together, but each system's particles are charged and packed alone.
void end_interactions(const Rank& rank, const Script& script, const Calculator& calculator, Round& round) {
  for (std::size_t i = round.first; i < round.last; ++i) {
    const System& system = *script.systems[i];
    if (!system.interacts()) continue;
    Population& here = *calculator.populations[i];
    here.tally.compute_s += rank.machine.timed([&] { end_list(rank, system, here); });
    pack_migrants(rank, system, here, round, static_cast<std::uint32_t>(i));
  }
}

// A rank that failed before its lists ran must still answer at the first interaction, or the others wait for it:
// whether there is one is known from the message that dealt the births, not from the rank's own list, which may be the
// error.
void run_lists(Rank& rank, const Script& script, Calculator& calculator, Round& round, Newborn& newborn) {
  InteractionSchedule course(rank, script, calculator, round);
  rank.session.work("act", [&] {
    if (script.in_frame()) act_on_all(rank, script, calculator, round, newborn, course);
  });
  if (!newborn.interact) return;
  if (rank.session.failed()) return say_failed(rank, round);  // its list may differ
  course.run();
  rank.session.work("act", [&] { end_interactions(rank, script, calculator, round); });
}

}  // namespace

void act(Rank& rank, Script& script, Calculator& calculator, Round& round, Newborn& newborn) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::act, "act", script.name_of(round));
  if (!newborn.from_manager.failed && rank.session.calculates()) run_lists(rank, script, calculator, round, newborn);
  for (std::size_t i = round.first; script.in_frame() && i < round.last; ++i) script.systems[i]->mark_run();
}

void sort_all(Rank& rank, const Script& script, Calculator& calculator) {
  if (!rank.session.calculates()) return;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::act, "order");
  const double start = rank.machine.compute_seconds();
  rank.session.work("sort", [&] {
    for (std::size_t i = 0; i < script.systems.size(); ++i) {
      sort(rank, *script.systems[i], calculator.populations[i]->store, 0);
    }
  });
  rank.machine.slow_down(start);
}

void call_back(const Calculator& calculator, std::size_t system, const recording::Callback& callback, double time,
               std::size_t begin) {
  Population& here = *calculator.populations[system];
  std::vector<std::uint32_t> chosen;
  if (!callback.where.empty()) {
    chosen = program::select(callback.where, callback.shapes, time, here.store, begin);
    if (chosen.empty()) return;
  }
  const Call call{static_cast<int>(system), callback.number, begin, callback.where.empty() ? nullptr : &chosen};
  ask_script(calculator, here, call);
}

void ask_script(const Calculator& calculator, Population& here, const Call& call) {
  here.in_callback = true;
  try {
    calculator.callback(call);
    particles::wrap(here.store);
  } catch (...) {
    here.in_callback = false;
    throw;
  }
  here.in_callback = false;
}

}  // namespace motes::engine
