// create (paper 3.2.1): the manager counts, numbers and makes the births of the frame and deals them out by domain;
// its message is also the notice that transmission has ended, and says what it was asked to do.
#include <algorithm>
#include <numeric>
#include <utility>

#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using comm::Message;
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
  std::vector<Hand> hands(cast_.calculators.size());
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
      for (const BirthGroup& group : groups_[i]) {
        charge(options_.costs.birth * static_cast<double>(group.count));
        if (bears_its_own()) {
          hands[0].count += group.count;
        } else {
          make_births(system, group, [&](const particles::Store& piece) { deal_out(system, piece, hands); });
        }
      }
    }
  });
  const recording::Hash hash = recording::hash(record_bytes_.view());
  for (int to = 0; to < comm_->size(); ++to) {
    Message message;
    message.bytes().put(hash);
    message.bytes().put(static_cast<std::uint32_t>(rounds_.size()));
    const int calculator = cast_.calculator_of(to);
    Hand hand = calculator >= 0 ? std::move(hands[static_cast<std::size_t>(calculator)]) : Hand{};
    if (!failure_.failed()) {
      message.bytes().put_raw(cuts.data(), cuts.size());
      message.bytes().put_raw(hand.bytes.data(), hand.bytes.size());
    }
    comm_->post(to, Phase::begin, stamp(round), std::move(message), hand.count, failure_.failed());
  }
}

void Engine::put_cuts(System& system, particles::Bytes& out) {
  out.put(system.new_cuts);
  if (!std::exchange(system.new_cuts, false)) return;
  const std::vector<float>& cuts = system.domains.cuts();
  out.put(static_cast<std::uint32_t>(cuts.size()));
  out.put_raw(cuts.data(), cuts.size() * sizeof(float));
}

void Engine::deal_out(const System& system, const particles::Store& newborn, std::vector<Hand>& hands) {
  std::vector<std::vector<std::uint32_t>> owned(hands.size());
  const float* x = newborn.plane(particles::position, system.definition.axis);
  for (std::size_t p = 0; p < newborn.size(); ++p) {
    owned[static_cast<std::size_t>(system.domains.owner_of(x[p]))].push_back(static_cast<std::uint32_t>(p));
  }
  for (std::size_t c = 0; c < hands.size(); ++c) {
    newborn.pack(owned[c], hands[c].bytes);
    hands[c].count += owned[c].size();
  }
}

Message Engine::receive_births(std::size_t round) {
  const Timed timed(*this, times_.create, "wait for births", name_of(rounds_[round]));
  Message message = comm_->expect(cast_.manager, Phase::begin, stamp(rounds_[round]));
  particles::Reader in = message.reader();
  if (in.get<recording::Hash>() != recording::hash(record_bytes_.view())) {
    failure_ = {Failure::Kind::mismatch, recording::name(record_.verb), "another list than the manager's"};
    // The conversation goes on by the manager's list until all agree that this one differs.
    const std::size_t before = rounds_.size();
    rounds_.resize(in.get<std::uint32_t>());
    for (std::size_t r = before; r < rounds_.size(); ++r) rounds_[r].turn = rounds_[r - 1].turn + 1;
  }
  return message;
}

// Groups are made and dealt out in pieces of so many particles: a large burst needs no memory of its own, and a piece
// stays in the second cache.
constexpr std::uint64_t kPiece = std::uint64_t{1} << 16;

void Engine::make_births(const System& system, const BirthGroup& group, const Use& use) const {
  for (std::uint64_t first = 0; first < group.count; first += kPiece) {
    use(system.make(group, first, std::min(kPiece, group.count - first), options_.dt, options_.substeps));
  }
}

void Engine::take_births(System& system, const BirthGroup& group, particles::Reader& births) {
  for (std::uint64_t first = 0; first < group.count; first += kPiece) system.store->unpack(births);
}

// The only calculator, when it is the manager too, makes births where they stay: no message holds them.
bool Engine::bears_its_own() const { return manages() && calculator() == 0 && cast_.calculators.size() == 1; }

// Makes what belongs here of a group.
void Engine::bear(System& system, const BirthGroup& group) const {
  const bool all = cast_.calculators.size() == 1;
  if (all) system.store->make_room(group.count);
  make_births(system, group, [&](const particles::Store& piece) {
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
  const Use note = [&](const particles::Store& store) {
    const float* x = store.plane(particles::position, system.definition.axis);
    coordinates.insert(coordinates.end(), x, x + store.size());
  };
  if (cast_.calculators.size() > 1) {  // one domain needs no cuts
    std::for_each(children.begin(), children.end(), note);
    for (const BirthGroup& group : groups) make_births(system, group, note);
  }
  system.domains = domains::quantiles(coordinates, static_cast<int>(cast_.calculators.size()));
  system.waits_for_fit = false;
  system.new_cuts = true;
}

}  // namespace motes::frame
