#include "engine/births/share.h"

#include <algorithm>
#include <numeric>

#include "base/enumerators.h"
#include "engine/births/birth_numbers.h"
#include "engine/session/item_failure.h"
#include "engine/state/places.h"

namespace motes::engine {

using comm::Message;
using comm::Phase;

namespace {

// Costs by which quicker_births() chooses, in seconds on one core of 2020. `python -m motes bench births` measures
// those per birth; a message is a small one on one host, sent and received. In each step of the ring all calculators
// wait for the slowest, which on busy hosts takes far longer than the messages.
constexpr double kDeal = 35e-9;    // manager: create a birth, find its owner, pack it
constexpr double kTake = 4e-9;     // calculator: unpack a birth
constexpr double kShare = 32e-9;  // calculators: create a birth, find its owner, sort its number, create it there
constexpr double kForward = 5e-9;  // calculator: forward a number, in each step except the last
constexpr double kMessage = 2e-6;  // calculator: a message to another calculator
constexpr double kStep = 100e-6;   // calculators: the wait for the slowest

// Returns the first number of calculator c's part of `count` births.
std::uint64_t share(std::uint64_t count, std::size_t calculators, std::size_t c) {
  return count / calculators * c + std::min<std::uint64_t>(c, count % calculators);
}

// Adds births first .. last - 1 of a group with their owners. If domains are cut by id, positions are not computed.
void find_owners(const Rank& rank, const System& system, const BirthGroup& group, std::uint64_t first,
                 std::uint64_t last, std::vector<Due>& births) {
  births.reserve(births.size() + (last - first));
  std::vector<std::uint32_t> owners;
  const auto add = [&](const domains::Places& places) {
    owners.resize(places.count);
    system.domains.owners_of(places, owners.data());
    for (std::size_t i = 0; i < places.count; ++i) {
      births.push_back({static_cast<std::uint32_t>(places.ids[i] - group.first_id), owners[i]});
    }
  };
  if (system.definition.axes.by_id()) {
    std::vector<std::uint64_t> ids(last - first);
    std::iota(ids.begin(), ids.end(), group.first_id + first);
    const particles::IdList halves(ids);
    add({{}, halves, ids.size()});
  } else {
    make_births(rank, system, group, first, last, [&](const particles::Store& piece) { add(places_of(piece)); });
  }
}

// Returns this calculator's part of all groups.
std::vector<BirthNumbers> make_share(const Rank& rank, const Script& script, const Round& round) {
  std::vector<BirthNumbers> groups;
  const std::size_t calculators = rank.session.calculators();
  const auto self = static_cast<std::size_t>(rank.session.calculator());
  for (std::size_t i = round.first; i < round.last; ++i) {
    const System& system = *script.systems[i];
    for (const BirthGroup& group : system.groups) {
      const std::uint64_t first = share(group.count, calculators, self);
      const std::uint64_t last = share(group.count, calculators, self + 1);
      groups.push_back({static_cast<std::uint32_t>(groups.size()), {}});
      of_item(system.list, i, group.item, [&] { find_owners(rank, system, group, first, last, groups.back().births); });
      rank.machine.charge(rank.machine.costs().share * static_cast<double>(last - first));
    }
  }
  return groups;
}

// Runs `work` on the births of all groups; blames the largest group for a failure, which is a lack of memory.
template <class Work>
void of_largest(const Script& script, const Round& round, const Work& work) {
  const BirthGroup* largest = nullptr;
  std::size_t owner = 0;
  for (std::size_t i = round.first; i < round.last; ++i) {
    for (const BirthGroup& group : script.systems[i]->groups) {
      if (largest && largest->count >= group.count) continue;
      largest = &group;
      owner = i;
    }
  }
  if (!largest) return work();
  of_item(script.systems[owner]->list, owner, largest->item, work);
}

// Returns the births at this calculator between two steps.
std::vector<BirthNumbers> between_steps(const Rank& rank, const Script& script, const Round& round,
                                        const std::vector<Message>& messages) {
  std::vector<BirthNumbers> groups;
  for (std::size_t i = round.first; i < round.last; ++i) {
    for (std::size_t g = 0; g < script.systems[i]->groups.size(); ++g) {
      groups.push_back({static_cast<std::uint32_t>(groups.size()), {}});
    }
  }
  of_largest(script, round,
             [&] { rank.machine.charge(rank.machine.costs().forward * static_cast<double>(join(messages, groups))); });
  return groups;
}

// Sends the step's messages; returns the births that stay and the received messages.
std::vector<Message> pass_on(Rank& rank, const Round& round, const roles::Ring& ring, int step,
                             std::vector<Message> messages) {
  Session& session = rank.session;
  const std::vector<int> ahead = ring.ahead(step);
  for (std::size_t m = 0; m < ahead.size(); ++m) {
    const std::uint64_t count = messages[m + 1].header().count;
    session.comm().post(session.rank_of(ahead[m]), Phase::births, session.stamp(round), std::move(messages[m + 1]),
                        count, session.failed());
  }
  messages.resize(1);
  for (const int from : ring.behind(step)) {
    messages.push_back(session.comm().expect(session.rank_of(from), Phase::births, session.stamp(round)));
  }
  return messages;
}

}  // namespace

Births births_named(const std::string& name) {
  return name == "auto" ? Births::automatic : base::enumerator<Births>("births", name);
}

Births quicker_births(std::uint64_t births, std::size_t calculators) {
  if (calculators < 2) return Births::manager;
  const roles::Ring ring(static_cast<int>(calculators), 0);
  std::size_t messages = 0;
  for (int step = 0; step < ring.steps(); ++step) messages += ring.ahead(step).size();
  const double each = static_cast<double>(births) / static_cast<double>(calculators);
  const double dealt_s = static_cast<double>(births) * kDeal + each * kTake;
  const double talk_s = ring.steps() * kStep + static_cast<double>(messages) * kMessage;
  const double shared_s = each * (kShare + kForward * (ring.steps() - 1)) + talk_s;
  return shared_s < dealt_s ? Births::calculators : Births::manager;
}

std::optional<Births> births_by(const Rank& rank, const Script& script) {
  std::uint64_t births = 0;
  for (const auto& system : script.systems) {
    for (const BirthGroup& group : system->groups) births += group.count;
  }
  if (births == 0) return std::nullopt;
  const std::size_t calculators = rank.session.calculators();
  if (calculators < 2) return Births::manager;
  return rank.settings.births == Births::automatic ? quicker_births(births, calculators) : rank.settings.births;
}

bool shares_births(const Rank& rank, const Script& script, const Round& round) {
  if (!script.in_frame() || births_by(rank, script) != Births::calculators) return false;
  return std::any_of(script.systems.begin() + static_cast<std::ptrdiff_t>(round.first),
                     script.systems.begin() + static_cast<std::ptrdiff_t>(round.last),
                     [](const auto& system) { return !system->groups.empty(); });
}

void share_births(Rank& rank, const Script& script, const Round& round, Newborn& newborn) {
  const roles::Ring ring(static_cast<int>(rank.session.calculators()), rank.session.calculator());
  for (int step = 0; step < ring.steps(); ++step) {
    for (const int from : ring.behind(step)) rank.session.comm().await(rank.session.rank_of(from), Phase::births);
  }
  for (int step = 0; step < ring.steps(); ++step) {
    std::vector<Message> messages(1 + ring.ahead(step).size());
    rank.session.work("create", [&] {
      const std::vector<BirthNumbers> groups =
          step == 0 ? make_share(rank, script, round) : between_steps(rank, script, round, newborn.shares);
      of_largest(script, round, [&] { messages = engine::split(groups, ring, step); });
    });
    newborn.shares = pass_on(rank, round, ring, step, std::move(messages));
  }
  for (const Message& message : newborn.shares) {
    newborn.readers.push_back(message.reader());
    newborn.count += message.header().count;
  }
}

void take_shares(const Rank& rank, const System& system, const BirthGroup& group, Newborn& newborn,
                 particles::Store& store) {
  std::vector<std::uint32_t> numbers;
  for (base::Reader& in : newborn.readers) take(in, newborn.group, group.count, numbers);
  ++newborn.group;
  store.make_room(numbers.size());
  make_births(rank, system, group, numbers, [&](const particles::Store& piece) { store.append(piece); });
  rank.machine.charge(rank.machine.costs().make * static_cast<double>(numbers.size()));
}

}  // namespace motes::engine
