#include "engine/births/create.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "base/hash.h"
#include "domains/divide.h"
#include "engine/balance/neighbours.h"
#include "engine/births/share.h"
#include "engine/render/render_load.h"
#include "engine/session/item_failure.h"
#include "engine/state/places.h"

namespace motes::engine {

using comm::Phase;

namespace {

// Particles per piece in which groups are created and dealt out: large bursts need little memory, and a piece fits into
// the L2 cache.
constexpr std::uint64_t kPiece = std::uint64_t{1} << 16;

void put_cuts(const System& system, Balancing& balancing, base::Bytes& out) {
  out.put(balancing.untold);
  if (!std::exchange(balancing.untold, false)) return;
  const std::vector<domains::Cut> cuts = system.domains.tree();
  out.put(static_cast<std::uint32_t>(cuts.size()));
  out.put_raw(cuts.data(), cuts.size() * sizeof(domains::Cut));
}

void take_cuts(Script& script, Calculator& calculator, std::size_t index, base::Reader& in) {
  if (!in.get<bool>()) return;
  std::vector<domains::Cut> cuts(in.get<std::uint32_t>());
  const auto bytes = in.take(cuts.size() * sizeof(domains::Cut));
  if (!cuts.empty()) std::memcpy(cuts.data(), bytes.data(), bytes.size());
  script.divide(index, domains::Domains::of(cuts, script.systems[index]->domains.curve()));
  // Particles may be outside their domain now; they migrate in the next exchange.
  for (const std::size_t i : script.sharing(index)) calculator.populations[i]->moved = true;
}

// Creates `births` particles in pieces, one per thread at a time, and calls `use` with each piece, in order.
template <class Make>
void make_pieces(const Rank& rank, const System& system, std::uint64_t births, const Make& make,
                 const std::function<void(const particles::Store&)>& use) {
  const std::uint64_t at_a_time = kPiece * static_cast<std::uint64_t>(rank.pool->threads());
  for (std::uint64_t first = 0; first < births; first += std::min(at_a_time, births - first)) {
    const std::uint64_t count = std::min(at_a_time, births - first);
    std::vector<particles::Store> pieces((count + kPiece - 1) / kPiece, particles::Store(system.schema));
    rank.pool->run(pieces.size(), [&](std::size_t piece, std::size_t) {
      const std::uint64_t begin = piece * kPiece;
      pieces[piece] = make(first + begin, std::min(kPiece, count - begin));
    });
    for (const particles::Store& piece : pieces) use(piece);
  }
}

// Packs the newborn particles by owner.
void deal_out(const Rank& rank, const System& system, const particles::Store& newborn,
              std::vector<RankMessage>& parts) {
  std::vector<std::vector<std::uint32_t>> owned(rank.session.calculators());
  std::vector<std::uint32_t> owners(newborn.size());
  system.domains.owners_of(places_of(newborn), owners.data());
  for (std::size_t p = 0; p < newborn.size(); ++p) owned[owners[p]].push_back(static_cast<std::uint32_t>(p));
  for (std::size_t c = 0; c < owned.size(); ++c) {
    RankMessage& part = parts[static_cast<std::size_t>(rank.session.rank_of(static_cast<int>(c)))];
    newborn.pack(owned[c], part.bytes, *rank.pool);
    part.count += owned[c].size();
  }
}

void deal_groups(const Rank& rank, const System& system, std::size_t index, std::vector<RankMessage>& parts) {
  for (const BirthGroup& group : system.groups) {
    rank.machine.charge(rank.machine.costs().birth * static_cast<double>(group.count));
    if (rank.creates_in_place()) {
      parts[static_cast<std::size_t>(rank.session.rank())].count += group.count;
    } else {
      of_item(system.list, index, group.item, [&] {
        make_births(rank, system, group, 0, group.count,
                    [&](const particles::Store& piece) { deal_out(rank, system, piece, parts); });
      });
    }
  }
}

// Adopts the manager's number of rounds, since this rank's list differs.
void follow(Script& script, std::uint32_t rounds) {
  const std::size_t before = script.rounds.size();
  script.rounds.resize(rounds);
  for (std::size_t r = before; r < script.rounds.size(); ++r) script.rounds[r].turn = script.rounds[r - 1].turn + 1;
}

// Applies the new cuts of all systems at once, since children of the first round may belong to a system of a later one.
void take_next_cuts(Script& script, Manager& manager) {
  for (std::size_t i = 0; i < script.systems.size(); ++i) {
    Balancing& balancing = manager.systems[i];
    const std::optional<domains::Domains> next = std::exchange(balancing.next, std::nullopt);
    if (!next) continue;
    script.divide(i, *next);
    balancing.untold = true;
  }
}

// Fits all domains in the first round: systems that share domains may be fitted to births of a later round, and all
// ranks must use the same cuts in a round.
void fit_all(const Rank& rank, Script& script, Manager& manager) {
  for (std::size_t i = 0; i < script.systems.size(); ++i) {
    if (fit(rank, script, i)) manager.systems[script.sharing(i).front()].untold = true;
  }
}

}  // namespace

void deal(Rank& rank, Script& script, Manager& manager, const Round& round) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::create, "create", script.name_of(round));
  base::Bytes cuts;
  std::vector<RankMessage> parts(static_cast<std::size_t>(rank.session.size()));
  const bool shared = shares_births(rank, script, round);
  rank.session.work("create", [&] {
    if (round.first == 0) {
      take_next_cuts(script, manager);
      fit_all(rank, script, manager);
    }
    for (std::size_t i = round.first; i < round.last; ++i) {
      const System& system = *script.systems[i];
      Balancing& balancing = manager.systems[i];
      put_cuts(system, balancing, cuts);
      if (!shared) deal_groups(rank, system, i, parts);
    }
  });
  base::Bytes common;
  common.put(script.hash);
  common.put(static_cast<std::uint32_t>(script.rounds.size()));
  common.put(script.overlaps);
  common.put(shared);
  common.put(interacts(script, round));
  common.put(compare_alone(rank, script, round));
  if (rank.session.failed()) {
    parts = std::vector<RankMessage>(parts.size());
  } else {
    put_plan(rank, script, round, manager.picture, common);
    common.put_raw(cuts.data(), cuts.size());
  }
  rank.session.relay().tell(Phase::begin, rank.session.stamp(round), common, parts, rank.session.failed());
}

Newborn receive_births(Rank& rank, Script& script, Calculator& calculator, std::size_t index) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::create, "wait for births",
                               script.name_of(script.rounds[index]));
  Newborn newborn;
  newborn.from_manager = rank.session.relay().hear(Phase::begin, rank.session.stamp(script.rounds[index]));
  newborn.count = newborn.from_manager.count;
  newborn.dealt = base::Reader(newborn.from_manager.own);
  base::Reader in(newborn.from_manager.common);
  const auto hash = in.get<base::Hash>();
  const auto rounds = in.get<std::uint32_t>();
  script.overlaps = in.get<bool>();
  newborn.shared = in.get<bool>();
  newborn.interact = in.get<bool>();
  newborn.compare = in.get<bool>();
  if (hash != script.hash) {
    if (!rank.session.failed()) {  // otherwise the earlier failure is the reason
      rank.session.fail(
          {Failure::Kind::mismatch, recording::name(script.record.verb), "its list differs from the manager's"});
    }
    follow(script, rounds);
  }
  const Round& round = script.rounds[index];
  if (!newborn.from_manager.failed) {
    rank.session.work("create", [&] {
      newborn.plan = take_plan(in);
      for (std::size_t i = round.first; i < round.last; ++i) {
        take_cuts(script, calculator, i, in);
      }
    });
  }
  if (newborn.shared && rank.session.calculates()) share_births(rank, script, round, newborn);
  return newborn;
}

void make_births(const Rank& rank, const System& system, const BirthGroup& group, std::uint64_t first,
                 std::uint64_t last, const std::function<void(const particles::Store&)>& use) {
  const auto make = [&](std::uint64_t begin, std::uint64_t count) {
    return system.make(group, first + begin, count, rank.settings.dt, rank.settings.substeps);
  };
  make_pieces(rank, system, last - first, make, use);
}

void make_births(const Rank& rank, const System& system, const BirthGroup& group,
                 std::span<const std::uint32_t> numbers, const std::function<void(const particles::Store&)>& use) {
  const auto make = [&](std::uint64_t begin, std::uint64_t count) {
    return system.make(group, numbers.subspan(begin, count), rank.settings.dt, rank.settings.substeps);
  };
  make_pieces(rank, system, numbers.size(), make, use);
}

void take_births(const Rank& rank, const System& system, const BirthGroup& group, Newborn& newborn,
                 particles::Store& store) {
  if (newborn.shared) return take_shares(rank, system, group, newborn, store);
  for (std::uint64_t first = 0; first < group.count; first += kPiece) store.unpack(newborn.dealt, *rank.pool);
}

void create_own(const Rank& rank, const System& system, const BirthGroup& group, particles::Store& store) {
  const bool all = rank.session.calculators() == 1;
  if (all) store.make_room(group.count);
  make_births(rank, system, group, 0, group.count, [&](const particles::Store& piece) {
    if (all) return store.append(piece);
    std::vector<std::uint32_t> owners(piece.size());
    system.domains.owners_of(places_of(piece), owners.data());
    const auto self = static_cast<std::uint32_t>(rank.session.calculator());
    std::vector<std::uint32_t> mine;
    for (std::size_t p = 0; p < piece.size(); ++p) {
      if (owners[p] == self) mine.push_back(static_cast<std::uint32_t>(p));
    }
    store.append(piece, mine, *rank.pool);
  });
}

bool fit(const Rank& rank, Script& script, std::size_t index) {
  const System& system = *script.systems[index];
  if (!system.waits_for_fit || system.groups.empty()) return false;
  std::array<std::vector<float>, 3> positions;
  if (rank.session.calculators() > 1) {  // one domain needs no cuts
    for (const BirthGroup& group : system.groups) {
      make_births(rank, system, group, 0, group.count, [&](const particles::Store& piece) {
        for (int axis = 0; axis < 3; ++axis) {
          if (!system.definition.axes.has(axis)) continue;
          const float* x = piece.plane(particles::position, axis);
          std::vector<float>& all = positions[static_cast<std::size_t>(axis)];
          all.insert(all.end(), x, x + piece.size());
        }
      });
    }
  }
  const std::size_t born = positions[static_cast<std::size_t>(system.definition.axes.first())].size();
  const domains::Places places{{positions[0].data(), positions[1].data(), positions[2].data()}, {}, born};
  script.divide(index,
                domains::quantiles(system.definition.axes, places, static_cast<int>(rank.session.calculators())));
  return true;
}

}  // namespace motes::engine
