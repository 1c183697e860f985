// Births that calculators send to their owners along a ring, as messages: everything arrives once, at the right place,
// under any order of events, also when calculators fail.
#include <algorithm>
#include <vector>

#include "comm/communicator.h"
#include "comm/simulated_ranks.h"
#include "roles/cast.h"
#include "roles/ring.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_ring_messages {
using comm::Message;
using comm::Phase;
using comm::SimulatedRank;
using comm::Stamp;

namespace {

struct Item {
  std::int32_t maker;
  std::int32_t owner;
  std::uint32_t number;
  bool operator==(const Item&) const = default;
  auto operator<=>(const Item&) const = default;
};

// Returns the births that calculator c creates in a turn: some for every owner, some for few, now and then none.
std::vector<Item> made(int calculators, int c, std::uint32_t turn) {
  test::Dice dice(1000 * turn + static_cast<std::uint64_t>(c));
  std::vector<Item> items(dice.below(4) == 0 ? 0 : dice.below(60));
  for (std::size_t i = 0; i < items.size(); ++i) {
    const auto owner = static_cast<std::int32_t>(dice.below(static_cast<std::size_t>(calculators)));
    items[i] = {c, owner, static_cast<std::uint32_t>(i)};
  }
  return items;
}

// Runs one step: sends what must travel on, returns what stays and what arrives.
std::vector<Item> pass_on(comm::Communicator& comm, const roles::Cast& cast, const roles::Ring& ring, int step,
                          Stamp stamp, const std::vector<Item>& items, bool failed) {
  const auto rank_of = [&](int c) { return cast.calculators[static_cast<std::size_t>(c)]; };
  const std::vector<int> ahead = ring.ahead(step);
  std::vector<Message> messages(ahead.size() + 1);
  std::vector<std::uint64_t> counts(messages.size());
  std::vector<Item> here;
  for (const Item& item : items) {
    const auto digit = static_cast<std::size_t>(ring.digit(item.owner, step));
    ++counts[digit];
    if (digit == 0) {
      here.push_back(item);
    } else {
      messages[digit].bytes().put(item);
    }
  }
  for (std::size_t m = 0; m < ahead.size(); ++m) {
    comm.post(rank_of(ahead[m]), Phase::births, stamp, std::move(messages[m + 1]), counts[m + 1], failed);
  }
  for (const int from : ring.behind(step)) {
    const Message message = comm.expect(rank_of(from), Phase::births, stamp);
    CHECK(message.payload().size() == message.header().count * sizeof(Item));
    for (base::Reader in = message.reader(); !in.done();) here.push_back(in.get<Item>());
  }
  return here;
}

// Runs a rank's births. `failing` creates and relays nothing, but takes part.
void births(SimulatedRank& self, const roles::Cast& cast, int failing, std::uint32_t turns) {
  comm::Communicator comm(self.transport(), {});
  const int calculators = static_cast<int>(cast.calculators.size());
  const int c = cast.calculator_of(comm.rank());
  for (std::uint32_t turn = 0; c >= 0 && turn < turns; ++turn) {
    const roles::Ring ring(calculators, c);
    std::vector<Item> items = made(calculators, c, turn);
    for (int step = 0; step < ring.steps(); ++step) {
      for (const int from : ring.behind(step)) {
        comm.await(cast.calculators[static_cast<std::size_t>(from)], Phase::births);
      }
      if (c == failing) items.clear();
      items = pass_on(comm, cast, ring, step, {2, turn}, items, c == failing);
    }
    if (c == failing) continue;
    std::vector<Item> due;
    for (int maker = 0; maker < calculators; ++maker) {
      for (const Item& item : made(calculators, maker, turn)) {
        if (item.owner == c) due.push_back(item);
      }
    }
    std::sort(items.begin(), items.end());
    if (failing < 0) {
      CHECK(items == due);
    } else {  // births that passed through the failing one are missing; nothing foreign arrived
      CHECK(std::includes(due.begin(), due.end(), items.begin(), items.end()));
    }
  }
  comm.finish();
}

}  // namespace

TEST(births_reach_their_owners_for_any_number_of_calculators) {
  for (int ranks = 1; ranks <= 64; ++ranks) {
    const roles::Cast cast = ranks % 2 == 0 ? roles::cast_auto(ranks) : roles::cast_shared(ranks);
    comm::simulate({.ranks = ranks, .seed = static_cast<std::uint64_t>(ranks)},
                   [&](SimulatedRank& self) { births(self, cast, -1, 2); });
  }
}

TEST(births_reach_their_owners_in_a_thousand_orders_of_events) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    comm::Simulation simulation;
    simulation.ranks = seed % 100 == 0 ? 20 : 2 + static_cast<int>(seed % 6);  // 20: two steps
    simulation.seed = seed;
    const roles::Cast cast = roles::cast_shared(simulation.ranks);
    const int failing = seed % 5 == 0 ? static_cast<int>(seed / 5) % simulation.ranks : -1;
    comm::simulate(simulation, [&](SimulatedRank& self) { births(self, cast, failing, 3); });
  }
}

}  // namespace motes::test_ring_messages
