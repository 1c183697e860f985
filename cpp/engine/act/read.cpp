#include "engine/act/read.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "engine/act/act.h"
#include "engine/act/run_list.h"
#include "engine/births/create.h"
#include "program/order.h"

namespace motes::engine {

namespace {

using comm::Message;
using comm::Phase;
using particles::Store;

// Adapts the indices in `outcome` to a new order of the particles: place i now holds particle from[i].
void follow(program::ListResult& outcome, const std::vector<std::uint32_t>& from) {
  std::vector<std::uint32_t> now(from.size());
  for (std::uint32_t p = 0; p < from.size(); ++p) now[from[p]] = p;
  for (std::vector<std::uint32_t>* list : {&outcome.dead, &outcome.hits}) {
    for (std::uint32_t& p : *list) p = now[p];
    std::sort(list->begin(), list->end());
  }
}

// Moves the dead to the end of the store after a partial run of the list: the script does not see them, but they keep
// moving until the frame ends.
void set_dead_aside(const Rank& rank, Population& here) {
  program::ListResult& outcome = here.outcome;
  outcome.left.clear();  // migrants are found at the frame's end
  if (outcome.dead.empty()) return;
  std::vector<std::uint32_t> from;
  from.reserve(here.store.size());
  auto dead = outcome.dead.begin();
  for (std::uint32_t p = 0; p < here.store.size(); ++p) {
    if (dead != outcome.dead.end() && *dead == p) {
      ++dead;
    } else {
      from.push_back(p);
    }
  }
  from.insert(from.end(), outcome.dead.begin(), outcome.dead.end());
  here.store.permute(from, *rank.pool);
  follow(outcome, from);
}

void run_and_arrange(Rank& rank, Script& script, const Calculator& calculator, std::size_t index) {
  System& system = *script.systems[index];
  system.count_births(rank.settings.dt, rank.settings.substeps);
  fit(rank, script, index);
  if (!rank.session.calculates()) return;
  Population& here = *calculator.populations[index];
  run_list(
      rank, system, here, [&](const BirthGroup& group) { create_own(rank, system, group, here.store); },
      [&](const recording::Callback& callback, double time, std::size_t begin) {
        call_back(calculator, index, callback, time, begin);
      },
      true);
  for (const actions::Action* action : system.sorts(system.run_items)) {
    follow(here.outcome, program::order(*action, rank.frame_time(), here.store, *rank.pool));
  }
  set_dead_aside(rank, here);
}

void end_part(System& system) {
  system.groups.clear();
  system.list.emplace_back(recording::Read{});
  system.mark_run();
}

// Runs the list so far in place. The result of the whole list does not change if it runs in two parts.
void run_in_place(Rank& rank, Script& script, const Calculator& calculator, std::size_t index) {
  Population& here = *calculator.populations[index];
  here.tally.compute_s += rank.machine.timed([&] { run_and_arrange(rank, script, calculator, index); });
  here.moved = true;
}

// Runs the list so far on a copy, and leaves everything else unchanged.
void run_preview(Rank& rank, Script& script, const Calculator& calculator, std::size_t index) {
  System& system = *script.systems[index];
  Population& here = *calculator.populations[index];
  const Counts counts = system.counts;
  const std::vector<recording::SourceTotal> sources = system.sources;
  const domains::Domains domains = system.domains;
  const bool waits_for_fit = system.waits_for_fit;
  const BirthHistory history = system.history;
  const Tally tally = here.tally;
  const program::ListResult outcome = here.outcome;
  const bool counts_afresh = here.counts_afresh;
  Store before(system.schema);
  before.append(here.store);
  const auto restore = [&] {
    here.preview =
        std::make_unique<Preview>(Preview{std::exchange(here.store, std::move(before)), here.outcome.dead.size(),
                                          system.list.size(), std::move(system.history)});
    here.outcome = outcome;
    here.tally = tally;
    here.counts_afresh = counts_afresh;
    system.counts = counts;
    system.sources = sources;
    script.divide(index, domains);
    for (const std::size_t i : script.sharing(index)) script.systems[i]->waits_for_fit = waits_for_fit;
    system.history = history;
    system.groups.clear();
  };
  try {
    run_and_arrange(rank, script, calculator, index);
  } catch (...) {
    restore();
    here.preview.reset();
    throw;
  }
  restore();
}

// A message that is passed around the ring or sent to rank 0; empty if its sender failed.
struct Passing {
  Message message;
  std::uint64_t count = 0;
  bool failed = false;
};

Passing packed(Rank& rank, const ParticlesView& seen) {
  Passing own;
  if (!rank.session.calculates()) return own;
  rank.session.work("gather", [&] {
    seen.store->pack(first_indices(seen.count), own.message.bytes(), *rank.pool);
    own.count = seen.count;
  });
  own.failed = rank.session.failed();
  if (own.failed) own.message = Message();
  return own;
}

void post(Session& session, int to, Passing passing) {
  session.comm().post(to, Phase::gather, session.stamp(), std::move(passing.message), passing.count, passing.failed);
}

Passing expect(Session& session, int from) {
  Passing heard{session.comm().expect(from, Phase::gather, session.stamp())};
  heard.count = heard.message.header().count;
  heard.failed = heard.message.header().failed != 0;
  return heard;
}

void take(Rank& rank, const Passing& passing, Store& gathered) {
  rank.session.work("gather", [&] {
    if (passing.failed) throw std::runtime_error("another rank could not send its particles");
    base::Reader in = passing.message.reader();
    if (!in.done()) gathered.unpack(in, *rank.pool);
  });
}

// Passes each message once around the ring: in step s each rank forwards the message received in step s - 1.
void pass_around(Rank& rank, Passing passing, Store& gathered) {
  Session& session = rank.session;
  const int next = (session.rank() + 1) % session.size();
  const int previous = (session.rank() + session.size() - 1) % session.size();
  for (int step = 1; step < session.size(); ++step) {
    take(rank, passing, gathered);
    post(session, next, std::move(passing));
    passing = expect(session, previous);
  }
  take(rank, passing, gathered);
}

}  // namespace

void check_readable(const System& system) {
  if (!system.interacts()) return;
  throw std::invalid_argument("particles of system '" + system.definition.name +
                              "' interact in this frame's list so far: read them before that, or after the frame");
}

ParticlesView seen(Population& here) {
  if (here.in_callback) return {&here.store, here.store.size(), false};
  if (here.preview) return {&here.preview->store, here.preview->store.size() - here.preview->dead, true};
  return {&here.store, here.seen(), false};
}

ParticlesView read(Rank& rank, Script& script, Calculator& calculator, int index) {
  const auto i = static_cast<std::size_t>(index);
  const System& system = *script.systems[i];
  Population& here = *calculator.populations[i];
  if (!system.pending() || (here.preview && here.preview->items == system.list.size())) return seen(here);
  const simd::FloatMode mode;
  if (rank.settings.substeps == 1) {
    run_in_place(rank, script, calculator, i);
    end_part(*script.systems[i]);
  } else {
    run_preview(rank, script, calculator, i);
  }
  return seen(here);
}

void pass_over(const Rank& rank, System& system) {
  if (rank.session.failed() && rank.settings.substeps == 1 && system.pending()) end_part(system);
}

void keep_preview(Rank& rank, Script& script, Calculator& calculator, int index) {
  const auto i = static_cast<std::size_t>(index);
  Population& here = *calculator.populations[i];
  if (!here.preview) return;
  const simd::FloatMode mode;
  System& system = *script.systems[i];
  std::vector<recording::Item>& list = system.list;
  const std::unique_ptr<Preview> written = std::move(here.preview);
  const auto later = list.begin() + static_cast<std::ptrdiff_t>(written->items);  // items that have not run on it
  std::vector<recording::Item> rest(std::make_move_iterator(later), std::make_move_iterator(list.end()));
  list.erase(later, list.end());
  rank.session.work("act", [&] {
    run_in_place(rank, script, calculator, i);  // the same particles in the same order as the preview
    here.store = std::move(written->store);
  });
  end_part(system);
  list.insert(list.end(), std::make_move_iterator(rest.begin()), std::make_move_iterator(rest.end()));
}

void read_copies(System& system, Population& here) {
  if (system.keeps_copies) return;
  keep_copies(system, here);
  const bool pending = system.pending();
  const bool shown = here.preview && here.preview->items == system.list.size();
  system.list.emplace_back(recording::KeepCopies{});
  if (!pending) system.mark_run();
  if (shown) here.preview->items = system.list.size();
}

void note_digest(const Rank& rank, const ParticlesView& seen, Population& here) {
  here.digest = particles::digest(*seen.store, *rank.pool);
  if (seen.count == seen.store->size()) return;
  std::vector<std::uint32_t> unseen(seen.store->size() - seen.count);
  std::iota(unseen.begin(), unseen.end(), static_cast<std::uint32_t>(seen.count));
  here.digest -= particles::digest(*seen.store, unseen);
}

std::unique_ptr<Store> gather(Rank& rank, const System& system, const ParticlesView& seen, bool to_all) {
  Session& session = rank.session;
  Passing own = packed(rank, seen);
  auto gathered = std::make_unique<Store>(system.schema);
  if (to_all) {
    pass_around(rank, std::move(own), *gathered);
  } else {
    if (session.calculates()) post(session, 0, std::move(own));
    const bool takes = session.rank() == 0;
    for (std::size_t c = 0; takes && c < session.calculators(); ++c) {
      take(rank, expect(session, session.cast().calculators[c]), *gathered);
    }
    if (!takes) gathered.reset();
  }
  session.rethrow();  // the other ranks learn of the failure in the next conversation
  return gathered;
}

}  // namespace motes::engine
