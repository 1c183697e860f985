// act and move (paper 3.2.2, 3.2.3): calculators run the recorded list in one pass and set leavers aside.
#include <algorithm>
#include <numeric>

#include "frame/engine.h"
#include "frame/work.h"
#include "recording/order.h"
#include "recording/select.h"

namespace motes::frame {

using particles::Store;

void Engine::act(Round& round, Newborn& newborn) {
  const Timed timed(*this, times_.act, "act", name_of(round));
  if (!newborn.heard.failed) {
    work("act", [&] {
      if (in_frame() && calculator() >= 0) act_on_all(round, newborn);
      for (std::size_t i = round.first; record_.verb == recording::Verb::digest && i < round.last; ++i) {
        digests_[i] = particles::digest(*systems_[i]->store);
      }
    });
  }
  for (std::size_t i = round.first; in_frame() && i < round.last; ++i) systems_[i]->mark_run();
}

void Engine::act_on_all(Round& round, Newborn& newborn) {
  std::uint64_t received = 0;
  for (std::size_t i = round.first; i < round.last; ++i) {
    const std::uint64_t before = systems_[i]->tally.created;
    act_on(*systems_[i], groups_[i], newborn);
    pack_leavers(round, i);
    received += systems_[i]->tally.created - before;
  }
  if (received != newborn.count) throw std::runtime_error("births were lost on the way");
}

void Engine::take_cuts(System& system, particles::Reader& in) {
  if (!in.get<bool>()) return;
  std::vector<float> cuts(in.get<std::uint32_t>());
  const auto bytes = in.take(cuts.size() * sizeof(float));
  if (!cuts.empty()) std::memcpy(cuts.data(), bytes.data(), bytes.size());
  system.domains = domains::Domains(std::move(cuts));
  system.waits_for_fit = false;
  system.moved = true;  // its particles may be outside now: the next exchange takes them to their owners
}

void Engine::act_on(System& system, const std::vector<BirthGroup>& groups, Newborn& newborn) {
  const double start = compute_seconds();
  const std::size_t children = system.store->size();
  if (system.children.count > 0) {
    system.store->unpack(newborn.dealt);
    system.tally.created += system.store->size() - children;
  }
  run_list(system, groups, children, [&](const BirthGroup& group) {
    if (bears_its_own()) {
      bear(system, group);
    } else {
      take_births(system, group, newborn);
    }
  });
  if (system.moved && system.outcome.left.empty()) {  // a list without actions has not looked for leavers
    recording::Program::find_leavers(*system.store, 0, slice_of(system), system.outcome);
    drop_dead(system.outcome);
  }
  charge_list(system);
  slow_down(start);
  system.tally.compute_s += compute_seconds() - start;
}

// What the list cost on all that it ran over: who was here or came, also who died or will leave.
void Engine::charge_list(const System& system) const {
  const auto newborn = static_cast<double>(system.tally.created);
  const double all = static_cast<double>(system.tally.at_start) + newborn;
  charge(options_.costs.newborn * newborn + options_.costs.of(system.list) * all * options_.substeps);
}

recording::Slice Engine::slice_of(const System& system) const {
  return {system.definition.axis, system.domains.low(calculator()), system.domains.high(calculator())};
}

// Old particles run the whole list, and so do the last frame's children, which stand behind them from `children` on;
// newborn ones enter it behind the call that made them.
void Engine::run_list(System& system, const std::vector<BirthGroup>& groups, std::size_t children,
                      const std::function<void(const BirthGroup&)>& append) {
  const std::vector<Piece> pieces = system.pending_pieces();
  std::vector<std::uint32_t> newborn(system.store->size() - children);
  std::iota(newborn.begin(), newborn.end(), static_cast<std::uint32_t>(children));
  const std::vector<const recording::Spawn*> rules = system.rules();
  system.outcome.clear();
  using On = recording::Spawn::On;
  const auto wanted = [&](On on) {
    return std::any_of(rules.begin(), rules.end(), [&](const recording::Spawn* rule) { return rule->on == on; });
  };
  system.outcome.wants_hits = wanted(On::collision);
  const bool wants_births = wanted(On::birth);
  run_pieces(system, pieces, 0, 0, 0);
  for (const BirthGroup& group : groups) {
    const std::size_t begin = system.store->size();
    append(group);
    for (std::size_t i = begin; wants_births && i < system.store->size(); ++i) {
      newborn.push_back(static_cast<std::uint32_t>(i));
    }
    system.tally.created += system.store->size() - begin;
    run_pieces(system, pieces, begin, group.entry, group.substep);
  }
  if (pieces.size() > 1 || pieces[0].callback != nullptr) {
    system.outcome.left.clear();
    recording::Program::find_leavers(*system.store, 0, slice_of(system), system.outcome);
    drop_dead(system.outcome);
  }
  system.tally.killed += system.outcome.dead.size();
  note_events(system, rules, newborn);
}

// Callbacks act between pieces of the list, so each sub-step runs piece by piece; without them all is one pass.
void Engine::run_pieces(System& system, const std::vector<Piece>& pieces, std::size_t begin, std::size_t entry,
                        int first_substep) {
  particles::Store& store = *system.store;
  recording::Span span{frame_, options_.substeps, options_.dt, first_substep, 0};
  if (pieces.size() == 1 && pieces[0].callback == nullptr) {
    pieces[0].program.run(store, begin, entry, span, system.key, slice_of(system), system.outcome);
    return;
  }
  if (begin >= store.size()) return;
  const recording::Slice everywhere{system.definition.axis};
  for (int substep = first_substep; substep < options_.substeps; ++substep) {
    span.first = substep;
    span.last = substep + 1;
    const std::size_t from = substep == first_substep ? entry : 0;
    for (const Piece& piece : pieces) {
      const std::size_t end = piece.first + piece.program.size();
      const std::size_t skip = std::min(from > piece.first ? from - piece.first : 0, piece.program.size());
      piece.program.run(store, begin, skip, span, system.key, everywhere, system.outcome);
      if (piece.callback != nullptr && from <= end) call_back(system, *piece.callback, begin);
    }
  }
}

void Engine::call_back(System& system, const recording::Callback& callback, std::size_t begin) {
  std::vector<std::uint32_t> chosen;
  if (!callback.where.empty()) {
    chosen = recording::select(callback.where, callback.shapes, *system.store, begin);
    if (chosen.empty()) return;
  }
  for (std::size_t i = 0; i < systems_.size(); ++i) {
    if (systems_[i].get() != &system) continue;
    callback_({static_cast<int>(i), callback.number, begin, callback.where.empty() ? nullptr : &chosen});
  }
}

// What `sort` is for: the particles that a calculator has at the end stand in the order of drawing.
void Engine::order() {
  if (calculator() < 0) return;
  const Timed timed(*this, times_.act, "order");
  const double start = compute_seconds();
  work("sort", [&] {
    for (const auto& system : systems_) order(*system, 0);
  });
  slow_down(start);
}

// Obeys the sorts from item `first` of the list on.
void Engine::order(System& system, std::size_t first) {
  for (std::size_t i = first; i < system.list.size(); ++i) {
    const auto* action = std::get_if<actions::Action>(&system.list[i]);
    if (action != nullptr && action->kind == actions::Kind::sort) recording::order(*action, *system.store);
  }
}

// Several passes may find the same particle dead; the dead do not leave. All lists become ascending again.
void Engine::drop_dead(recording::Outcome& outcome) {
  for (std::vector<std::uint32_t>* list : {&outcome.dead, &outcome.left, &outcome.hits}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  std::erase_if(outcome.left,
                [&](std::uint32_t p) { return std::binary_search(outcome.dead.begin(), outcome.dead.end(), p); });
}

// Before the dead go: what the spawn rules want to know.
void Engine::note_events(System& system, const std::vector<const recording::Spawn*>& rules,
                         const std::vector<std::uint32_t>& newborn) {
  using On = recording::Spawn::On;
  system.events.resize(rules.size());
  for (std::size_t r = 0; r < rules.size(); ++r) {
    const recording::Outcome& outcome = system.outcome;
    const auto& indices = rules[r]->on == On::birth ? newborn : rules[r]->on == On::death ? outcome.dead : outcome.hits;
    const std::vector<recording::Event> found = recording::events_of(*rules[r], *system.store, indices);
    system.events[r].insert(system.events[r].end(), found.begin(), found.end());
  }
}

particles::Store& Engine::local(int index) {
  catch_up();
  System& s = system(index);
  if (!s.pending()) return *s.store;
  const simd::FloatMode mode;
  const bool calculates = calculator() >= 0;
  const std::vector<BirthGroup> groups = s.count_births(frame_, options_.dt, options_.substeps);
  const double start = compute_seconds();
  fit(s, groups, {});
  if (calculates) {
    run_list(s, groups, s.store->size(), [&](const BirthGroup& group) { bear(s, group); });
    s.store->remove(s.outcome.dead);
    s.outcome.clear();
    order(s, s.run_items);
    s.moved = true;
    slow_down(start);
    s.tally.compute_s += compute_seconds() - start;
  }
  s.list.emplace_back(recording::Read{});
  s.mark_run();
  return *s.store;
}

// The dead go; those that left their domain are packed for their owners and go too.
void Engine::pack_leavers(Round& round, std::size_t index) {
  System& system = *systems_[index];
  Store& store = *system.store;
  std::map<int, std::vector<std::uint32_t>> to;
  std::vector<std::uint32_t> gone;
  const float* x = store.plane(particles::position, system.definition.axis);
  for (const std::uint32_t p : system.outcome.left) {
    const int owner = system.domains.owner_of(x[p]);
    if (owner == calculator()) continue;  // infinitely far out, or no number: it belongs here
    to[owner].push_back(p);
    gone.push_back(p);
  }
  if (options_.digest) {
    digests_[index] = particles::digest(store);
    digests_[index] -= particles::digest(store, system.outcome.dead);
  }
  for (const auto& [owner, leavers] : to) {
    particles::Bytes& bytes = round.leaving[owner].bytes();
    const std::size_t before = bytes.size();
    bytes.put(static_cast<std::uint32_t>(index));
    store.pack(leavers, bytes);
    system.sent.push_back({owner, leavers.size()});
    system.tally.bytes_sent += bytes.size() - before;
  }
  system.tally.sent = gone.size();
  const double among = options_.costs.gap * static_cast<double>(store.size()) * options_.costs.scale;
  charge((options_.costs.leave + among) * static_cast<double>(gone.size()));
  std::vector<std::uint32_t> all(gone.size() + system.outcome.dead.size());
  std::merge(gone.begin(), gone.end(), system.outcome.dead.begin(), system.outcome.dead.end(), all.begin());
  store.remove(all);
  system.outcome.clear();
}

}  // namespace motes::frame
