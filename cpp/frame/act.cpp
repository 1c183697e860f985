// act and move (paper 3.2.2, 3.2.3): calculators run the recorded list in one pass and set leavers aside.
#include <algorithm>

#include "comm/clock.h"
#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using particles::Store;

void Engine::act(const comm::Message& births) {
  const double start = comm::wall_seconds();
  leaving_.clear();
  leaving_.resize(cast_.calculators.size());
  sent_.assign(systems_.size(), {});
  if (births.header().failed == 0) {
    work("act", [&] {
      particles::Reader in = births.reader();
      in.get<recording::Hash>();
      for (const auto& system : systems_) take_cuts(*system, in);
      if (in_frame() && calculator() >= 0) act_on_all(in, births.header().count);
      for (std::size_t i = 0; record_.verb == recording::Verb::digest && i < systems_.size(); ++i) {
        digests_[i] = particles::digest(*systems_[i]->store);
      }
    });
  }
  for (std::size_t i = 0; in_frame() && i < systems_.size(); ++i) systems_[i]->mark_run();
  times_.act = comm::wall_seconds() - start;
}

void Engine::act_on_all(particles::Reader& births, std::uint64_t expected) {
  std::uint64_t received = 0;
  for (std::size_t i = 0; i < systems_.size(); ++i) {
    const std::uint64_t before = systems_[i]->tally.created;
    act_on(*systems_[i], groups_[i], births);
    pack_leavers(*systems_[i], i);
    received += systems_[i]->tally.created - before;
  }
  if (received != expected) throw std::runtime_error("births were lost on the way from the manager");
}

void Engine::take_cuts(System& system, particles::Reader& in) {
  if (!in.get<bool>()) return;
  std::vector<float> cuts(in.get<std::uint32_t>());
  const auto bytes = in.take(cuts.size() * sizeof(float));
  if (!cuts.empty()) std::memcpy(cuts.data(), bytes.data(), bytes.size());
  system.domains = domains::Domains(std::move(cuts));
  system.waits_for_fit = false;
}

void Engine::act_on(System& system, const std::vector<BirthGroup>& groups, particles::Reader& births) {
  const double start = comm::cpu_seconds();
  run_list(system, groups, [&](std::size_t) { system.store->unpack(births); });
  if (system.pending_program().size() == 0 && system.moved) {
    const recording::Slice slice{system.definition.axis, system.domains.low(calculator()),
                                 system.domains.high(calculator())};
    recording::Program::find_leavers(*system.store, 0, slice, system.outcome);
  }
  system.tally.compute_s += comm::cpu_seconds() - start;
}

// Old particles run the whole list; newborn ones enter it behind the call that made them.
void Engine::run_list(System& system, const std::vector<BirthGroup>& groups,
                      const std::function<void(std::size_t)>& append) {
  Store& store = *system.store;
  const recording::Program program = system.pending_program();
  const recording::Slice slice{system.definition.axis, system.domains.low(calculator()),
                               system.domains.high(calculator())};
  recording::Span span{frame_, options_.substeps, options_.dt, 0};
  system.outcome.clear();
  program.run(store, 0, 0, span, system.key, slice, system.outcome);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::size_t begin = store.size();
    append(g);
    system.tally.created += store.size() - begin;
    span.first = groups[g].substep;
    program.run(store, begin, groups[g].entry, span, system.key, slice, system.outcome);
  }
  system.tally.killed += system.outcome.dead.size();
}

particles::Store& Engine::local(int index) {
  System& s = system(index);
  if (!s.pending()) return *s.store;
  const simd::FloatMode mode;
  const bool calculates = calculator() >= 0;
  const std::vector<BirthGroup> groups = s.count_births(frame_, options_.dt, options_.substeps);
  const double start = comm::cpu_seconds();
  const Stores newborn = calculates || s.waits_for_fit ? make_births(s, groups) : Stores{};
  if (calculates) {
    run_list(s, groups, [&](std::size_t g) {
      const Store& store = newborn[g];
      const float* x = store.plane(particles::position, s.definition.axis);
      std::vector<std::uint32_t> mine;
      for (std::size_t p = 0; p < store.size(); ++p) {
        if (s.domains.owner_of(x[p]) == calculator()) mine.push_back(static_cast<std::uint32_t>(p));
      }
      particles::Bytes bytes;
      store.pack(mine, bytes);
      particles::Reader in(bytes.view());
      s.store->unpack(in);
    });
    s.store->remove(s.outcome.dead);
    s.outcome.clear();
    s.moved = true;
    s.tally.compute_s += comm::cpu_seconds() - start;
  }
  s.list.emplace_back(recording::Read{});
  s.mark_run();
  return *s.store;
}

// The dead go; those that left their domain are packed for their owners and go too.
void Engine::pack_leavers(System& system, std::size_t index) {
  Store& store = *system.store;
  std::vector<std::vector<std::uint32_t>> to(leaving_.size());
  std::vector<std::uint32_t> gone;
  const float* x = store.plane(particles::position, system.definition.axis);
  for (const std::uint32_t p : system.outcome.left) {
    const int owner = system.domains.owner_of(x[p]);
    if (owner == calculator()) continue;  // infinitely far out, or no number: it belongs here
    to[static_cast<std::size_t>(owner)].push_back(p);
    gone.push_back(p);
  }
  if (options_.digest) {
    digests_[index] = particles::digest(store);
    digests_[index] -= particles::digest(store, system.outcome.dead);
  }
  for (std::size_t c = 0; c < to.size(); ++c) {
    const std::size_t before = leaving_[c].bytes().size();
    store.pack(to[c], leaving_[c].bytes());
    if (to[c].empty()) continue;
    sent_[index].push_back({static_cast<std::int32_t>(c), to[c].size()});
    system.tally.bytes_sent += leaving_[c].bytes().size() - before;
  }
  system.tally.sent = gone.size();
  std::vector<std::uint32_t> all(gone.size() + system.outcome.dead.size());
  std::merge(gone.begin(), gone.end(), system.outcome.dead.begin(), system.outcome.dead.end(), all.begin());
  store.remove(all);
  system.outcome.clear();
}

}  // namespace motes::frame
