// Parts of checkpoints, and the state that all ranks share. Simulated disasters test that a world continues from them
// with the same bits, on other ranks and with other cuts: test_recovery.cpp.
#include <cstring>
#include <memory>
#include <numeric>
#include <vector>

#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "particles/digest.h"
#include "snapshots/part.h"
#include "support/check.h"
#include "threads/pool.h"

namespace motes::test_snapshots {

TEST(a_part_has_whole_ids_whatever_their_upper_halves) {
  const particles::Schema schema;
  for (const std::uint64_t first : {std::uint64_t{0}, (std::uint64_t{1} << 32) - 70'000, std::uint64_t{5} << 32}) {
    particles::Store store(schema), again(schema);
    std::vector<std::uint64_t> ids(140'003);
    std::iota(ids.begin(), ids.end(), first);
    store.grow(ids.size());
    store.set_ids(0, ids);
    snapshots::Description description;
    description.systems.push_back({"all", 0});
    base::Bytes planes;
    planes.put(std::uint8_t{0});  // nothing is aligned
    threads::Pool pool(2);
    snapshots::copy({&store}, description, planes, pool);
    CHECK(std::memcmp(planes.data() + 1, ids.data(), ids.size() * sizeof ids[0]) == 0);
    const auto rest = planes.view().subspan(1);
    snapshots::append(description, rest, 0, 129, ids.size(), again, pool);
    snapshots::append(description, rest, 0, 0, 129, again, pool);
    CHECK(again.ids()[0] == first + 129 && again.ids()[ids.size() - 129] == first);
    CHECK(digest(again, pool) == digest(store, pool));
    CHECK((again.ids().upper == nullptr) == (first == 0));
  }
}

TEST(a_state_of_another_world_is_refused) {
  base::Bytes state;
  for (const std::uint64_t seed : {4, 4, 5}) {
    comm::simulate({.ranks = 1}, [&](comm::SimulatedRank& self) {
      engine::Settings settings;
      settings.seed = seed;
      engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}),
                            roles::cast_shared(1), settings);
      engine.add_system({});
      engine.start();
      const std::vector<engine::Sample> samples(1);
      if (seed == 5) CHECK_THROWS(engine.restore_state(state.view(), samples), std::runtime_error);
      if (!state.empty() && seed == 4) engine.restore_state(state.view(), samples);
      state = engine.shared_state();
      engine.finish();
    });
  }
}

}  // namespace motes::test_snapshots
