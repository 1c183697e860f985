#include "engine/act/ghost_exchange.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/fields.h"
#include "engine/act/run_list.h"

namespace motes::engine {

using comm::Message;
using comm::Phase;
using particles::Store;

namespace {

// Marks the particles inside a box that are farther than `range` metres from each of its faces. Returns false if
// positions have no plane.
bool mark_deep(const Store& store, const domains::Box& box, double range, std::vector<std::uint8_t>& deep) {
  const float* x[3];
  double low[3], high[3];
  for (int c = 0; c < 3; ++c) {
    const auto a = static_cast<std::size_t>(c);
    x[c] = store.plane(particles::position, c);
    if (x[c] == nullptr) return false;
    low[c] = static_cast<double>(box.low[a]) + range;
    high[c] = static_cast<double>(box.high[a]) - range;
  }
  for (std::size_t i = 0; i < store.size(); ++i) {
    bool inside = true;
    for (int c = 0; c < 3; ++c)
      inside &= static_cast<double>(x[c][i]) > low[c] && static_cast<double>(x[c][i]) < high[c];
    deep[i] = deep[i] | static_cast<std::uint8_t>(inside);
  }
  return true;
}

void position_of(const Store& store, std::size_t i, float (&x)[3]) {
  for (int c = 0; c < 3; ++c) x[c] = store.value(particles::position, c, i);
}

GhostExchange::Migrants migrants_of(const Rank& rank, const System& system, const Images& images, Population& here) {
  GhostExchange::Migrants migrants;
  find_migrants(rank, system, here);
  migrants.to = migrants_by_owner(rank, system, here);
  here.outcome.left.clear();
  const domains::BoxCover own = images.ends(system.domains.cover(rank.session.calculator()));
  for (const auto& [owner, particles] : migrants.to) {
    for (const std::uint32_t p : particles) {
      float x[3];
      position_of(here.store, p, x);
      migrants.farthest = std::max(migrants.farthest, images.outside(own, x));
    }
  }
  return migrants;
}

// Appends the ids of those migrants in `gone` that are in `noted`, for their new owner.
template <class Ids>
void put_noted(const Population& here, const Ids& noted, const std::vector<std::uint32_t>& gone, base::Bytes& out) {
  std::vector<std::uint64_t> found;
  for (const std::uint32_t p : gone) {
    const std::uint64_t id = here.store.ids()[p];
    if (noted.contains(id)) found.push_back(id);
  }
  base::write_fields(found, out);
}

template <class Ids>
void take_noted(base::Reader& in, Ids& noted) {
  std::vector<std::uint64_t> found;
  base::read_fields(in, found);
  noted.insert(found.begin(), found.end());
}

}  // namespace

bool GhostExchange::holds() {
  bool all = true;
  for (std::size_t side = 0; side < in_.count(); ++side) {
    const interactions::NeighbourList& list = in_.calculator.neighbours[in_.key(side)];
    const bool holds = action_.holds(side);
    all = all && holds && kept_ghosts(side).domains == in_.system(side).domains;
    wear_.step = std::max(wear_.step, list.wear().step);
    wear_.age = std::max(wear_.age, list.wear().age);
    // While lists are kept, particles do not migrate; the skin bounds how far outside their domain they are.
    migrants_[side].farthest = static_cast<double>(list.skin());
  }
  return all;
}

void GhostExchange::find_migrants() {
  if (in_.rank.session.calculators() == 1) return;
  for (std::size_t side = 0; side < in_.count(); ++side)
    migrants_[side] = migrants_of(in_.rank, in_.system(side), images_, in_.population(side));
}

// Returns the part of a calculator's domain that particles can be in.
const domains::BoxCover& GhostExchange::cover(std::size_t side, int calculator) const {
  const auto [found, is_new] = covers_[side].try_emplace(calculator);
  if (is_new) found->second = images_.ends(in_.system(side).domains.cover(calculator));
  return found->second;
}

// Returns whether `from` may have migrants or ghosts for `to`. Both ends compute this from the same cuts and the agreed
// distances, so a rank knows whom to wait for without asking; a message may turn out to be empty.
bool GhostExchange::concerns(int from, int to) const {
  for (std::size_t a = 0; a < in_.count(); ++a) {
    const domains::BoxCover& own = cover(a, from);
    if (images_.within(own, cover(a, to), farthest_)) return true;
    if (images_.within(own, cover(in_.seer(a), to), farthest_ + range_)) return true;
  }
  return false;
}

void GhostExchange::await(const std::vector<int>& from) const {
  for (const int source : from) in_.rank.session.comm().await(in_.rank.session.rank_of(source), Phase::interaction);
}

// Sends the messages; those of a rank whose compute failed are empty, but sent, since others wait for them.
void GhostExchange::send(std::map<int, Message>& messages) {
  const bool failed = in_.rank.session.failed();
  for (auto& [target, message] : messages) {
    if (failed) message = Message();
    in_.population(0).interaction.bytes += message.payload().size();
    in_.rank.session.comm().post(in_.rank.session.rank_of(target), Phase::interaction,
                                 in_.rank.session.stamp(in_.round), std::move(message), failed ? 0 : sent_[target],
                                 failed);
  }
}

// Messages are read in the order of the ranks, not of their arrival, so that a run repeats itself down to the order of
// particles in memory.
template <class Unpack>
void GhostExchange::hear(const std::vector<int>& from, const Unpack& unpack) {
  for (const int source : from) {
    const Message message = in_.rank.session.comm().expect(in_.rank.session.rank_of(source), Phase::interaction,
                                                           in_.rank.session.stamp(in_.round));
    if (message.header().failed == 0) in_.compute([&] { unpack(source, message); });
  }
}

// Migrants and ghosts share a message: a particle that has just left is on its new owner before that acts, and no
// second round of messages is needed.
void GhostExchange::exchange(double farthest, double range) {
  farthest_ = farthest;
  range_ = range;
  forget_ghosts();
  const bool sees_images = images_.any() && !nearest_;
  if (in_.rank.session.calculators() == 1 && !sees_images) return;
  const int self = in_.rank.session.calculator();
  const int count = static_cast<int>(in_.rank.session.calculators());
  std::vector<int> to;
  std::vector<int> from;
  for (int other = 0; other < count; ++other) {
    if (other != self && concerns(self, other)) to.push_back(other);
    if (other != self && concerns(other, self)) from.push_back(other);
  }
  std::uint16_t& neighbour_ranks = in_.population(0).interaction.neighbour_ranks;
  neighbour_ranks = std::max(neighbour_ranks, static_cast<std::uint16_t>(std::min<std::size_t>(to.size(), UINT16_MAX)));
  await(from);
  std::map<int, Message> messages;
  for (const int target : to) messages[target];
  in_.compute([&] {
    for (std::size_t side = 0; side < in_.count(); ++side) pack(side, messages);
  });
  send(messages);
  in_.compute([&] {
    for (std::size_t side = 0; side < in_.count(); ++side) remove_migrants(side);
  });
  hear(from, [&](int, const Message& message) { unpack(message); });
  if (lists_) in_.compute([&] { keep_ghosts(to); });
  if (!images_.any()) return;
  in_.compute([&] {
    for (std::size_t side = 0; side < in_.count(); ++side) place_ghosts(images_, ghosts(side));
  });
}

void GhostExchange::forget_ghosts() {
  for (std::size_t side = 0; side < in_.count(); ++side) {
    if (lists_) kept_ghosts(side) = {{}, in_.system(side).domains, {}, {}, {}};
  }
}

// Keeps the ghosts just exchanged, on both ends, so that refresh() can send only what changes.
void GhostExchange::keep_ghosts(const std::vector<int>& others) {
  for (std::size_t side = 0; side < in_.count(); ++side) {
    KeptGhosts& ghosts_here = kept_ghosts(side);
    find_owners(ghosts_here.domains, ghosts_here);
    const std::vector<std::uint32_t> near = near_the_border(side);
    const int self = in_.rank.session.calculator();
    std::vector<int> targets = others;
    if (images_.any()) targets.push_back(self);
    for (const int target : targets) {
      const domains::BoxCover& seer = cover(in_.seer(side), target);
      Chosen seen;
      for (const std::uint32_t p : near) choose(side, seer, p, target == self ? 1 : 0, seen);
      if (seen.size() == 0) continue;
      sort_by_id(in_.population(side).store, seen.particles);
      ghosts_here.sent[target] = std::move(seen.particles);
    }
  }
}

// Sends and receives the changed columns of kept ghosts since the last interaction.
void GhostExchange::refresh() {
  if (images_.any()) in_.compute([&] { refresh_own_images(); });
  std::map<int, Message> messages;
  std::set<int> sources;
  for (std::size_t side = 0; side < in_.count(); ++side) {
    for (const auto& [source, places] : kept_ghosts(side).received) sources.insert(source);
    for (const auto& [target, particles] : kept_ghosts(side).sent) messages[target];
  }
  sources.erase(in_.rank.session.calculator());
  messages.erase(in_.rank.session.calculator());
  const std::vector<int> from(sources.begin(), sources.end());
  await(from);
  in_.compute([&] {
    for (auto& [target, message] : messages) sent_[target] = pack_changes(target, message.bytes());
  });
  send(messages);
  hear(from, [&](int source, const Message& message) { unpack_changes(source, message); });
}

// Sends this calculator's images to itself, as it sends them to others: one way to read them, one result.
void GhostExchange::refresh_own_images() {
  const int self = in_.rank.session.calculator();
  for (std::size_t side = 0; side < in_.count(); ++side) {
    KeptGhosts& ghosts_here = kept_ghosts(side);
    if (!ghosts_here.sent.contains(self)) continue;
    base::Bytes bytes;
    put_changes(action_.reads(side), in_.population(side).store, self, ghosts_here, bytes);
    base::Reader in(bytes.view());
    take_changes(in, self, images_, ghosts_here);
  }
}

std::uint64_t GhostExchange::pack_changes(int target, base::Bytes& bytes) {
  std::uint64_t count = 0;
  for (std::size_t side = 0; side < in_.count(); ++side) {
    KeptGhosts& ghosts_here = kept_ghosts(side);
    if (!ghosts_here.sent.contains(target)) continue;
    const std::uint64_t changed =
        put_changes(action_.reads(side), in_.population(side).store, target, ghosts_here, bytes);
    in_.population(side).interaction.ghosts += changed;
    in_.rank.machine.charge(in_.rank.machine.costs().copy * static_cast<double>(changed));
    count += changed;
  }
  return count;
}

void GhostExchange::unpack_changes(int source, const Message& message) {
  base::Reader in = message.reader();
  std::uint64_t count = 0;
  for (std::size_t side = 0; side < in_.count(); ++side) {
    KeptGhosts& ghosts_here = kept_ghosts(side);
    if (ghosts_here.received.contains(source)) count += take_changes(in, source, images_, ghosts_here);
  }
  in_.rank.machine.charge(in_.rank.machine.costs().copy * static_cast<double>(count));
  if (count != message.header().count || !in.done())
    throw std::runtime_error("kept ghosts differ from what their owner sends");
}

// Adds the places, from number `first` on, at which particles of the domain `seer` may see particle `p`. Where the
// action finds nearest images, each particle is a ghost once, at its own position.
void GhostExchange::choose(std::size_t side, const domains::BoxCover& seer, std::uint32_t p, std::uint8_t first,
                           Chosen& chosen) const {
  const Store& store = in_.population(side).store;
  float x[3];
  position_of(store, p, x);
  if (std::isnan(x[0] + x[1] + x[2]) || (nearest_ && first > 0)) return;
  for (std::uint8_t number = first; number < images_.count(); ++number) {
    const float at[3] = {images_.at(number, 0, x[0]), images_.at(number, 1, x[1]), images_.at(number, 2, x[2])};
    if (!within(seer, at, range_)) continue;
    chosen.particles.push_back(p);
    if (images_.any()) chosen.images.push_back(nearest_ ? 0 : number);
    if (nearest_) return;
  }
}

// Returns the particles that other calculators may see or that migrate: all except those deep inside this calculator's
// domain.
std::vector<std::uint32_t> GhostExchange::near_the_border(std::size_t side) const {
  if (!seen(side)) return {};
  const System& sees = in_.system(in_.seer(side));
  const Store& store = in_.population(side).store;
  const domains::BoxCover& own = cover(side, in_.rank.session.calculator());
  const bool nothing_deep = sees.domains != in_.system(side).domains || own.whole == 0 || own.around == domains::Box{};
  if (nothing_deep) return action_.sources(side, first_indices(store.size()));
  std::vector<std::uint8_t> deep(store.size(), 0);
  for (std::size_t i = 0; i < own.whole; ++i) {
    if (!mark_deep(store, own.boxes[i], range_, deep)) return action_.sources(side, first_indices(store.size()));
  }
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < deep.size(); ++i) {
    if (deep[i] == 0) found.push_back(static_cast<std::uint32_t>(i));
  }
  return action_.sources(side, std::move(found));
}

// Packs, for each calculator, its new particles and ghosts of the particles within reach of its domain.
void GhostExchange::pack(std::size_t side, std::map<int, Message>& messages) {
  Population& here = in_.population(side);
  const int self = in_.rank.session.calculator();
  std::map<std::uint32_t, int> owners;
  for (const auto& [owner, migrants] : migrants_[side].to) {
    for (const std::uint32_t p : migrants) owners[p] = owner;
  }
  interactions::write_down_touches(in_.calculator.neighbours, in_.number(side), owners, here.store);
  const std::vector<std::uint32_t> near = near_the_border(side);
  const auto owner_of = [&](std::uint32_t p) {
    const auto migrant = owners.find(p);
    return migrant == owners.end() ? self : migrant->second;
  };
  for (auto& [target, message] : messages) {
    base::Bytes& bytes = message.bytes();
    const auto leaving = migrants_[side].to.find(target);
    const std::vector<std::uint32_t> none;
    const std::vector<std::uint32_t>& gone = leaving == migrants_[side].to.end() ? none : leaving->second;
    here.store.pack(gone, bytes, *in_.rank.pool);
    put_noted(here, here.bounced, gone, bytes);
    put_noted(here, here.collided, gone, bytes);
    // A particle is a ghost on other calculators; on its owner, only its images are ghosts.
    const domains::BoxCover& seer = cover(in_.seer(side), target);
    Chosen copied;
    for (const std::uint32_t p : near) choose(side, seer, p, owner_of(p) == target ? 1 : 0, copied);
    put_ghosts(action_.reads(side), here.store, copied, bytes);
    sent_[target] += gone.size() + copied.size();
    here.interaction.ghosts += copied.size();
    in_.rank.machine.charge(in_.rank.machine.costs().copy * static_cast<double>(copied.size()));
  }
  base::Bytes kept;  // ghosts of leaving migrants and images that this calculator sees
  const domains::BoxCover& own = cover(in_.seer(side), self);
  Chosen copied;
  std::vector<std::uint32_t> leaving;
  for (const auto& [p, owner] : owners) leaving.push_back(p);
  if (!seen(side)) leaving.clear();
  for (const std::uint32_t p : action_.sources(side, std::move(leaving))) choose(side, own, p, 0, copied);
  for (const std::uint32_t p : near) {
    if (images_.any() && owner_of(p) == self) choose(side, own, p, 1, copied);
  }
  put_ghosts(action_.reads(side), here.store, copied, kept);
  base::Reader in(kept.view());
  take_ghosts(in, action_.reads(side).size(), images_.any(), ghosts(side));
}

// Removes the migrants after all messages are packed, since their ghosts were read from the store.
void GhostExchange::remove_migrants(std::size_t side) {
  Population& here = in_.population(side);
  std::vector<std::uint32_t> gone;
  for (const auto& [owner, migrants] : migrants_[side].to) gone.insert(gone.end(), migrants.begin(), migrants.end());
  if (gone.empty()) return;
  std::sort(gone.begin(), gone.end());
  here.store.remove(gone, *in_.rank.pool);
  here.interaction.moved_out += gone.size();
  in_.rank.machine.charge(in_.rank.machine.costs().leave * static_cast<double>(gone.size()));
}

void GhostExchange::unpack(const Message& message) {
  base::Reader in = message.reader();
  std::uint64_t count = 0;
  for (std::size_t side = 0; side < in_.count(); ++side) {
    Population& here = in_.population(side);
    const std::size_t before = here.store.size();
    here.store.unpack(in, *in_.rank.pool);
    const std::size_t arrived = here.store.size() - before;
    here.interaction.moved_in += arrived;
    take_noted(in, here.bounced);
    take_noted(in, here.collided);
    const std::uint64_t seen = take_ghosts(in, action_.reads(side).size(), images_.any(), ghosts(side));
    count += arrived + seen;
    const Costs& costs = in_.rank.machine.costs();
    in_.rank.machine.charge(costs.arrive * static_cast<double>(arrived) + costs.copy * static_cast<double>(seen));
  }
  if (count != message.header().count || !in.done())
    throw std::runtime_error("particles were lost on the way between calculators");
}

}  // namespace motes::engine
