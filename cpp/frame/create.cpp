// create (paper 3.2.1): the manager counts, numbers and makes the births of the frame and deals them out by domain;
// its message is also the notice that transmission has ended, and says what it was asked to do. share.cpp is another
// way: the calculators make births.
#include <algorithm>
#include <numeric>
#include <utility>

#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using comm::Phase;

void Engine::count_births() {
  groups_.assign(systems_.size(), {});
  for (std::size_t i = 0; in_frame() && i < systems_.size(); ++i) {
    groups_[i] = systems_[i]->count_births(frame_, options_.dt, options_.substeps);
  }
}

void Engine::deal(const Round& round) {
  const Timed timed(*this, times_.create, "create", name_of(round));
  particles::Bytes cuts;
  std::vector<Part> hands(static_cast<std::size_t>(comm_->size()));
  const bool shared = shares_births(round);
  work("create", [&] {
    for (std::size_t i = round.first; i < round.last; ++i) {
      System& system = *systems_[i];
      Stores children;
      if (system.next_domains) {
        system.domains = *std::exchange(system.next_domains, std::nullopt);
        system.new_cuts = true;
      }
      if (in_frame() && system.children.count > 0) children.push_back(make_children(system));
      fit(system, groups_[i], children);
      put_cuts(system, cuts);
      for (const particles::Store& store : children) deal_out(system, store, hands);
      if (!shared) deal_groups(i, hands);
    }
  });
  particles::Bytes common;
  common.put(recording::hash(record_bytes_.view()));
  common.put(static_cast<std::uint32_t>(rounds_.size()));
  common.put(shared);
  if (failure_.failed()) {
    hands = std::vector<Part>(hands.size());
  } else {
    common.put_raw(cuts.data(), cuts.size());
  }
  relay_.tell(Phase::begin, stamp(round), common, hands, failure_.failed());
}

void Engine::deal_groups(std::size_t index, std::vector<Part>& hands) {
  const System& system = *systems_[index];
  for (const BirthGroup& group : groups_[index]) {
    charge(options_.costs.birth * static_cast<double>(group.count));
    if (bears_its_own()) {
      hands[static_cast<std::size_t>(rank())].count += group.count;
    } else {
      make_births(system, group, 0, group.count,
                  [&](const particles::Store& piece) { deal_out(system, piece, hands); });
    }
  }
}

void Engine::put_cuts(System& system, particles::Bytes& out) {
  out.put(system.new_cuts);
  if (!std::exchange(system.new_cuts, false)) return;
  const std::vector<float>& cuts = system.domains.cuts();
  out.put(static_cast<std::uint32_t>(cuts.size()));
  out.put_raw(cuts.data(), cuts.size() * sizeof(float));
}

void Engine::deal_out(const System& system, const particles::Store& newborn, std::vector<Part>& hands) const {
  std::vector<std::vector<std::uint32_t>> owned(cast_.calculators.size());
  std::vector<std::uint32_t> owners(newborn.size());
  system.domains.owners_of({newborn.plane(particles::position, system.definition.axis), newborn.size()}, owners.data());
  for (std::size_t p = 0; p < newborn.size(); ++p) owned[owners[p]].push_back(static_cast<std::uint32_t>(p));
  for (std::size_t c = 0; c < owned.size(); ++c) {
    Part& hand = hands[static_cast<std::size_t>(cast_.calculators[c])];
    newborn.pack(owned[c], hand.bytes);
    hand.count += owned[c].size();
  }
}

Engine::Newborn Engine::receive_births(std::size_t index) {
  const Timed timed(*this, times_.create, "wait for births", name_of(rounds_[index]));
  Newborn newborn;
  newborn.heard = relay_.hear(Phase::begin, stamp(rounds_[index]));
  newborn.count = newborn.heard.count;
  newborn.dealt = particles::Reader(newborn.heard.own);
  particles::Reader in(newborn.heard.common);
  const auto hash = in.get<recording::Hash>();
  const auto rounds = in.get<std::uint32_t>();
  newborn.shared = in.get<bool>();
  if (hash != recording::hash(record_bytes_.view())) {
    failure_ = {Failure::Kind::mismatch, recording::name(record_.verb), "another list than the manager's"};
    // The conversation goes on by the manager's list until all agree that this one differs.
    const std::size_t before = rounds_.size();
    rounds_.resize(rounds);
    for (std::size_t r = before; r < rounds_.size(); ++r) rounds_[r].turn = rounds_[r - 1].turn + 1;
  }
  const Round& round = rounds_[index];
  if (!newborn.heard.failed) {
    work("create", [&] {
      for (std::size_t i = round.first; i < round.last; ++i) take_cuts(*systems_[i], in);
    });
  }
  if (newborn.shared && calculator() >= 0) share_births(round, newborn);
  return newborn;
}

// Groups are made and dealt out in pieces of so many particles: a large burst needs no memory of its own, and a piece
// stays in the second cache.
constexpr std::uint64_t kPiece = std::uint64_t{1} << 16;

// Those with the numbers first .. last - 1 within the group.
void Engine::make_births(const System& system, const BirthGroup& group, std::uint64_t first, std::uint64_t last,
                         const Use& use) const {
  for (; first < last; first += std::min(kPiece, last - first)) {
    use(system.make(group, first, std::min(kPiece, last - first), options_.dt, options_.substeps));
  }
}

void Engine::take_births(System& system, const BirthGroup& group, Newborn& newborn) {
  if (newborn.shared) return take_shares(system, newborn);
  for (std::uint64_t first = 0; first < group.count; first += kPiece) system.store->unpack(newborn.dealt);
}

// The only calculator, when it is the manager too, makes births where they stay: no message holds them.
bool Engine::bears_its_own() const { return manages() && calculator() == 0 && cast_.calculators.size() == 1; }

// Makes what belongs here of a group.
void Engine::bear(System& system, const BirthGroup& group) const {
  const bool all = cast_.calculators.size() == 1;
  if (all) system.store->make_room(group.count);
  make_births(system, group, 0, group.count, [&](const particles::Store& piece) {
    const float* x = piece.plane(particles::position, system.definition.axis);
    std::vector<std::uint32_t> mine;
    for (std::size_t p = 0; p < piece.size(); ++p) {
      if (all || system.domains.owner_of(x[p]) == calculator()) mine.push_back(static_cast<std::uint32_t>(p));
    }
    particles::Bytes bytes;
    piece.pack(mine, bytes);
    particles::Reader in(bytes.view());
    system.store->unpack(in);
  });
}

// What the last frame's events bear: one store, in the order of their ids.
particles::Store Engine::make_children(System& system) {
  particles::Store all(system.schema);
  std::uint64_t first = system.children.first_id;
  std::uint64_t left = system.children.count;
  for (const recording::Offspring& offspring : system.offspring) {
    const particles::Store some =
        recording::make(offspring, system.schema, system.key, first, left, system.keeps_copies);
    std::vector<std::uint32_t> everyone(some.size());
    std::iota(everyone.begin(), everyone.end(), 0u);
    particles::Bytes bytes;
    some.pack(everyone, bytes);
    particles::Reader in(bytes.view());
    all.unpack(in);
    first += some.size();
    left -= some.size();
  }
  system.offspring.clear();
  return all;
}

// space "fit": the first births decide where the domains lie.
void Engine::fit(System& system, const std::vector<BirthGroup>& groups, const Stores& children) const {
  if (!system.waits_for_fit || (groups.empty() && children.empty())) return;
  std::vector<float> coordinates;
  const auto note = [&](const particles::Store& store) {
    const float* x = store.plane(particles::position, system.definition.axis);
    coordinates.insert(coordinates.end(), x, x + store.size());
  };
  if (cast_.calculators.size() > 1) {  // one domain needs no cuts
    std::for_each(children.begin(), children.end(), note);
    for (const BirthGroup& group : groups) make_births(system, group, 0, group.count, note);
  }
  system.domains = domains::quantiles(coordinates, static_cast<int>(cast_.calculators.size()));
  system.waits_for_fit = false;
  system.new_cuts = true;
}

}  // namespace motes::frame
