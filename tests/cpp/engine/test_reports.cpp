// Reports and verdicts along the tree: how many messages and bytes reach the manager, which ranks receive what, and
// what all ranks learn when some of them fail or record something else.
#include <algorithm>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"
#include "support/forwarding_transport.h"

namespace motes::test_reports {
using comm::Phase;
using comm::SimulatedRank;

namespace {

constexpr int kFrames = 4;

// Counts what arrives at a rank.
struct Arrived {
  std::map<Phase, int> messages;
  std::map<Phase, std::size_t> bytes;
};

class Counting final : public test::Forwarding {
 public:
  Counting(std::unique_ptr<Transport> under, Arrived& arrived) : Forwarding(std::move(under)), arrived_(arrived) {}
  std::optional<base::Bytes> receive(int from, Phase phase) override {
    auto bytes = Forwarding::receive(from, phase);
    if (bytes) {
      ++arrived_.messages[phase];
      arrived_.bytes[phase] += bytes->size();
    }
    return bytes;
  }

 private:
  Arrived& arrived_;
};

engine::Settings settings(int fan_out, engine::Combine combine = engine::Combine::together) {
  engine::Settings settings;
  settings.costs.act.fill(1000);
  settings.fan_out = fan_out;
  settings.combine = combine;
  return settings;
}

// Records particles that fly apart: some leave for both neighbours in each frame.
void record(engine::Engine& engine, int system) {
  recording::Source source;
  source.shape = {shapes::Kind::box, {-30, -3, -1, 30, 3, 1}};
  source.rate = 24 * 400;
  const actions::distributions::InShape velocity{{shapes::Kind::box, {-20, 0, 0, 20, 1, 1}}};
  source.state = {{particles::velocity, velocity}};
  engine.record(system, source);
  engine.record(system, actions::make(actions::numbers::move<>{.rotational = 1}));
}

recording::SystemDefinition definition(const std::string& name) {
  recording::SystemDefinition made;
  made.name = name;
  made.space = {domains::Space::Kind::finite, -30, 30};
  return made;
}

// Returns what the manager receives in the frames themselves.
Arrived at_the_manager(int ranks, int fan_out, int systems) {
  Arrived arrived;
  comm::simulate({.ranks = ranks}, [&](SimulatedRank& self) {
    Arrived elsewhere;
    Arrived& here = self.rank() == 1 ? arrived : elsewhere;  // the manager of cast_auto
    auto communicator =
        std::make_unique<comm::Communicator>(std::make_unique<Counting>(self.transport(), here), comm::Watch{});
    engine::Engine engine(std::move(communicator), roles::cast_auto(ranks), settings(fan_out));
    for (int i = 0; i < systems; ++i) engine.add_system(definition(std::to_string(i)));
    engine.start();
    here = {};
    for (int i = 0; i < kFrames; ++i) {
      for (int system = 0; system < systems; ++system) record(engine, system);
      engine.run_frame(std::nullopt);
    }
    const Arrived in_frames = here;
    engine.finish();
    here = in_frames;
  });
  return arrived;
}

}  // namespace

TEST(the_manager_hears_as_many_reports_as_it_has_children_and_no_more_bytes_than_loads) {
  for (const int systems : {1, 3}) {
    for (const int fan_out : {2, 4, 8}) {
      for (const int ranks : {5, 14, 34, 60}) {
        const Arrived arrived = at_the_manager(ranks, fan_out, systems);
        const int children = std::min(fan_out, ranks - 1);
        CHECK(arrived.messages.at(Phase::report) == kFrames * children);
        // The load of each calculator and, from each child, a report whose size does not depend on the number of ranks
        // below it: particles that cross the borders of its part of the tree come from few calculators.
        const auto loads =
            static_cast<std::size_t>(ranks - 2) * static_cast<std::size_t>(systems) * sizeof(engine::CalculatorLoad);
        const auto reports = static_cast<std::size_t>(children) * static_cast<std::size_t>(600 + 300 * systems);
        CHECK(arrived.bytes.at(Phase::report) <= kFrames * (loads + reports));
        CHECK(!arrived.messages.contains(Phase::log));  // no log was requested
      }
    }
  }
}

namespace {

// Returns what each calculator received of each system, in all frames that the manager knows completely.
std::vector<std::uint64_t> received_by_each(int ranks, int fan_out, engine::Combine combine) {
  std::vector<std::uint64_t> received;
  std::uint64_t sent = 0, arrived = 0;
  comm::simulate({.ranks = ranks}, [&](SimulatedRank& self) {
    engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}),
                          roles::cast_auto(ranks), settings(fan_out, combine));
    for (int i = 0; i < 2; ++i) engine.add_system(definition(std::to_string(i)));
    engine.start();
    for (int i = 0; i < kFrames; ++i) {
      for (int system = 0; system < 2; ++system) record(engine, system);
      engine.run_frame(std::nullopt);
      if (!engine.last_row()) continue;
      for (const engine::LoadRow& load : engine.last_row()->load) {
        received.push_back(load.tally.received);
        arrived += load.tally.received;
        sent += load.tally.sent;
      }
    }
    engine.finish();
  });
  CHECK(sent > 0 && arrived == sent);
  return received;
}

}  // namespace

TEST(arrivals_are_counted_wherever_the_reports_of_sender_and_receiver_meet) {
  for (const auto combine : {engine::Combine::one_by_one, engine::Combine::together}) {
    for (const int ranks : {5, 14}) {
      const auto expected = received_by_each(ranks, ranks, combine);  // all meet at the manager
      for (const int fan_out : {1, 2, 3}) CHECK(received_by_each(ranks, fan_out, combine) == expected);
    }
  }
}

namespace {

// How each rank ended: its own exception, or the rank that all blame.
struct End {
  std::string own;
  int blamed = -1;
  std::vector<std::int32_t> differ;
  std::uint64_t frame = 0;
};

struct Trouble {
  int ranks = 1;
  bool shared = false;
  int fan_out = 8;
  engine::Combine combine = engine::Combine::together;
  std::vector<int> failing;    // ranks whose callback throws
  std::vector<int> differing;  // ranks with a different list
};

bool contains(const std::vector<int>& list, int rank) {
  return std::find(list.begin(), list.end(), rank) != list.end();
}

// Returns a run without trouble yet, whose shape depends on the seed.
Trouble trouble_of(std::uint64_t seed, int ranks) {
  Trouble trouble;
  trouble.ranks = ranks;
  trouble.shared = seed % 2 == 0;
  trouble.fan_out = 1 + static_cast<int>(seed % 3);
  trouble.combine = static_cast<engine::Combine>(seed / 2 % 3);
  return trouble;
}

void play(SimulatedRank& self, const Trouble& trouble, std::map<int, End>& ends) {
  const roles::Cast cast = trouble.shared ? roles::cast_shared(trouble.ranks) : roles::cast_auto(trouble.ranks);
  engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), cast,
                        settings(trouble.fan_out, trouble.combine));
  for (int i = 0; i < 3; ++i) engine.add_system(definition(std::to_string(i)));
  End& end = ends[self.rank()];
  int frame = 0;
  engine.on_callback([&](const engine::Call& call) {
    if (frame == 2 && call.system == 1 && contains(trouble.failing, self.rank())) throw std::logic_error("broken");
  });
  try {
    engine.start();
    for (; frame < kFrames; ++frame) {
      for (int system = 0; system < 3; ++system) {
        record(engine, system);
        engine.record(system, recording::Callback{"look", 0, {}, {}});
      }
      if (frame == 2 && contains(trouble.differing, self.rank())) {
        engine.record(2, actions::make(actions::numbers::gravity<>{.acceleration = {0, -1, 0}}));
      }
      engine.run_frame(std::nullopt);
    }
  } catch (const std::logic_error& error) {
    end.own = error.what();
  } catch (const engine::Agreed& agreed) {
    end.blamed = agreed.verdict().failed_rank;
    end.differ = agreed.verdict().ranks;
    end.frame = agreed.frame();
  }
}

std::map<int, End> ends_of(const Trouble& trouble, std::uint64_t seed) {
  std::map<int, End> ends;
  for (int rank = 0; rank < trouble.ranks; ++rank) ends[rank] = {};
  comm::simulate({.ranks = trouble.ranks, .seed = seed}, [&](SimulatedRank& self) { play(self, trouble, ends); });
  return ends;
}

}  // namespace

TEST(all_ranks_blame_the_lowest_rank_that_failed_wherever_it_stands) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Trouble trouble = trouble_of(seed, 2 + static_cast<int>(seed % 12));
    const int calculators = trouble.shared ? trouble.ranks : std::max(1, trouble.ranks - 2);
    const int lowest = trouble.ranks - 1 - static_cast<int>(seed * 7) % calculators;
    trouble.failing = {lowest, trouble.ranks - 1};
    for (const auto& [rank, end] : ends_of(trouble, seed)) {
      if (rank == lowest) CHECK(end.own == "broken");
      if (rank != lowest) CHECK(end.blamed == lowest && end.frame == 2 && end.own.empty());
    }
  }
}

TEST(all_ranks_hear_who_recorded_another_list_wherever_it_stands) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Trouble trouble = trouble_of(seed, 4 + static_cast<int>(seed % 10));
    const int other = static_cast<int>(seed * 5) % trouble.ranks;
    trouble.differing = {other};
    if (seed % 3 == 0) trouble.failing = {trouble.ranks - 1};  // a further failure is not reported
    for (const auto& [rank, end] : ends_of(trouble, seed)) {
      const bool own = end.own == "broken" && contains(trouble.failing, rank);
      CHECK(own || (end.blamed == other && end.differ == std::vector<std::int32_t>{other} && end.frame == 2));
    }
  }
}

}  // namespace motes::test_reports
