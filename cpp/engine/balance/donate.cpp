#include "engine/balance/donate.h"

#include <algorithm>
#include <array>
#include <span>

#include "balance/cells.h"
#include "balance/cuts.h"
#include "engine/state/places.h"

namespace motes::engine {
namespace {

// Returns coordinates along an axis or a curve, or the numbers by which ids are cut.
std::span<const float> coordinates(const System& system, const Population& here, int axis, std::vector<float>& room) {
  if (axis < domains::kById) return {here.store.plane(particles::position, axis), here.store.size()};
  room.resize(here.store.size());
  if (const auto& curve = system.domains.curve()) {
    curve->places_of(places_of(here.store), 0, room.size(), room.data());
    return room;
  }
  for (std::size_t p = 0; p < room.size(); ++p) room[p] = domains::scattered(here.store.ids()[p]);
  return room;
}

// Returns the coordinates of this calculator's particles in all systems that share these domains.
std::span<const float> coordinates(const Script& script, const Calculator& calculator, std::size_t system, int axis,
                                   std::vector<float>& room) {
  const std::vector<std::size_t> sharing = script.sharing(system);
  if (sharing.size() == 1) return coordinates(*script.systems[system], *calculator.populations[system], axis, room);
  std::vector<float> of_one;
  for (const std::size_t i : sharing) {
    const std::span<const float> more = coordinates(*script.systems[i], *calculator.populations[i], axis, of_one);
    room.insert(room.end(), more.begin(), more.end());
  }
  return room;
}

std::vector<balance::Cell> cells(const Script& script, const Calculator& calculator, std::size_t system, int most) {
  const domains::Axes axes = script.systems[system]->definition.axes;
  std::array<std::vector<float>, 3> room;
  domains::Places places;
  for (int axis = 0; axis < 3; ++axis) {
    if (!axes.has(axis)) continue;
    const auto a = static_cast<std::size_t>(axis);
    const std::span<const float> x = coordinates(script, calculator, system, axis, room[a]);
    places.position[a] = x.data();
    places.count = x.size();
  }
  return balance::cells(axes, places, most);
}

// Answers a request, apart from its cost.
Proposal answer(const Rank& rank, const Script& script, const Calculator& calculator, const Request& request) {
  const auto index = static_cast<std::size_t>(request.system);
  const System& system = *script.systems[index];
  Proposal proposal{request, {}, {}, {}};
  if (request.kind == Request::Kind::cells) {
    proposal.cells = cells(script, calculator, index, static_cast<int>(request.count));
    return proposal;
  }
  std::vector<float> room;
  const std::span<const float> x = coordinates(script, calculator, index, system.definition.axes.first(), room);
  const float low = system.domains.low(rank.session.calculator());
  const float high = system.domains.high(rank.session.calculator());
  switch (request.kind) {
    case Request::Kind::cells: break;
    case Request::Kind::give_left: proposal.gift = balance::give_left(x, request.count, low, high); break;
    case Request::Kind::give_right: proposal.gift = balance::give_right(x, request.count, low, high); break;
    case Request::Kind::histogram: proposal.histogram = balance::histogram(x, static_cast<int>(request.count)); break;
  }
  return proposal;
}

}  // namespace

Proposal propose(const Rank& rank, const Script& script, const Calculator& calculator, const Request& request) {
  const auto index = static_cast<std::size_t>(request.system);
  std::uint64_t particles = 0;
  for (const std::size_t i : script.sharing(index)) particles += calculator.populations[i]->store.size();
  const double start = rank.machine.compute_seconds();
  rank.machine.charge(rank.machine.costs().select * static_cast<double>(particles));
  Proposal proposal = answer(rank, script, calculator, request);
  calculator.populations[index]->handling.search.add(particles, rank.machine.compute_seconds() - start);
  return proposal;
}

std::vector<Density> densities(const Script& script, const Calculator& calculator) {
  std::vector<Density> densities;
  std::vector<float> room;
  for (std::size_t i = 0; i < script.systems.size(); ++i) {
    const Population& here = *calculator.populations[i];
    Density density;
    density.particles = here.store.size();
    const domains::Axes axes = script.systems[i]->definition.axes;
    float* to = density.quantiles;
    for (int axis = axes.first(); axis < 3 || axis == axes.first(); ++axis) {
      if (axis < 3 && !axes.has(axis)) continue;
      const std::vector<float> q = balance::quantiles(coordinates(*script.systems[i], here, axis, room), kQuantiles);
      if (q.empty()) density.particles = 0;
      to = std::copy(q.begin(), q.end(), to);
    }
    densities.push_back(density);
  }
  return densities;
}

}  // namespace motes::engine
