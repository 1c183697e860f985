// Snapshots on simulated ranks: a world that goes on from one, on other ranks, in other roles, with other cuts, has the
// bits of one that was never left.
#include <cstring>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "check.h"
#include "comm/simulated_ranks.h"
#include "falling_source.h"
#include "frame/engine.h"
#include "owners.h"
#include "particles/digest.h"
#include "particles/fields.h"
#include "snapshots/part.h"
#include "threads/pool.h"

namespace motes::test_snapshots {
using comm::SimulatedRank;

namespace {

constexpr int kFrames = 9;

struct Way {
  int ranks = 1;
  bool shared = true;
  std::uint8_t axes = 1;
  frame::Combine combine = frame::Combine::together;
  frame::Births births = frame::Births::manager;
  int threads = 1;
  std::uint64_t born = 0;  // by each system before the first frame
};

// What a world is between two frames, as all ranks together have it.
struct Saved {
  particles::Bytes shared;
  std::map<int, snapshots::Description> descriptions;  // by calculator
  std::map<int, particles::Bytes> planes;
};

struct Film {
  std::vector<std::string> digests;
  std::vector<Saved> saved;  // one per frame
  std::size_t moved = 0;  // particles that the next frame brought to their owners
};

void record(frame::Engine& engine, int frame) {
  recording::Spawn spawn;
  spawn.into = 1;
  spawn.on = recording::Spawn::On::collision;
  spawn.count = 2;
  engine.record(0, test::falling_source(60));
  engine.record(0, spawn);
  engine.record(0, actions::Action{actions::Kind::gravity, {0, -9.81, 0}, {}});
  engine.record(0,
                actions::Action{actions::Kind::bounce, {0.5, 0.1, 0, 1}, {{shapes::Kind::plane, {0, 0, 0, 0, 1, 0}}}});
  engine.record(0, actions::Action{actions::Kind::kill_old, {0.4, 0}, {}});
  // From here on the values at birth are asked for, also of particles that were born before the snapshot.
  if (frame > 5) engine.record(0, actions::Action{actions::Kind::restore, {1, 1, 1}, {}});
  engine.record(0, actions::Action{actions::Kind::move, {1}, {}});
  engine.record(1, test::falling_source(20));
  engine.record(1, actions::Action{actions::Kind::kill_old, {0.2, 0}, {}});
  engine.record(1, actions::Action{actions::Kind::move, {1}, {}});
}

void define(frame::Engine& engine, const Way& way) {
  recording::SystemDefinition definition;
  definition.space = {domains::Space::Kind::finite, -3.2, 0.8};
  definition.axes.bits = way.axes;
  definition.name = "parents";
  engine.add_system(definition);
  definition.name = "children";
  definition.capacity = 90;
  engine.add_system(definition);
}

// Each calculator takes its share of all parts, as many in a row as it gets.
void restore(frame::Engine& engine, const Saved& saved) {
  std::vector<frame::Sample> samples(2);
  for (std::size_t system = 0; system < 2; ++system) {
    for (const auto& [part, description] : saved.descriptions) {
      frame::take_sample(description, saved.planes.at(part).view(), system, 40, samples[system]);
    }
  }
  engine.restore_state(saved.shared.view(), samples);
  if (!engine.talk().calculates()) return;
  const auto own = static_cast<std::uint64_t>(engine.talk().calculator());
  for (std::size_t system = 0; system < 2; ++system) {
    for (const auto& [part, description] : saved.descriptions) {
      const std::uint64_t rows = description.systems[system].rows;
      const std::uint64_t count = engine.talk().calculators();
      engine.restore_rows(description, saved.planes.at(part).view(), system, rows * own / count,
                          rows * (own + 1) / count);
    }
  }
}

void play(SimulatedRank& self, const Way& way, const Saved* from, Film& film) {
  const roles::Cast cast = way.shared ? roles::cast_shared(way.ranks) : roles::cast_auto(way.ranks);
  frame::Settings settings;
  settings.seed = 4;
  settings.substeps = 2;
  settings.combine = way.combine;
  settings.births = way.births;
  settings.threads = way.threads;
  settings.grain = 16;
  frame::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), cast, settings);
  define(engine, way);
  engine.start();
  if (from != nullptr) {
    restore(engine, *from);
  } else {
    for (int system = 0; system < 2; ++system) engine.system(system).counts.born = way.born;
  }
  while (engine.frame() < kFrames) {
    const auto frame = static_cast<int>(engine.frame());
    record(engine, frame);
    engine.run_frame(std::nullopt);
    test::check_owners(engine);
    const std::string digest = particles::combine(engine.digest()).text();
    if (self.rank() == 0) {
      film.digests.push_back(digest + " " + std::to_string(engine.system(1).counts.dropped));
      film.saved.emplace_back();
      film.saved.back().shared = engine.shared_state();
    }
    engine.digest();  // all are here before the next one is saved
    if (engine.talk().calculates()) {
      Saved& saved = film.saved.back();
      const int calculator = engine.talk().calculator();
      saved.descriptions[calculator] = engine.copy_part(saved.planes[calculator]);
    }
    engine.digest();
  }
  engine.finish();
}

Film run(const Way& way, std::uint64_t seed, const Saved* from = nullptr) {
  comm::Simulation simulation;
  simulation.ranks = way.ranks;
  simulation.seed = seed;
  Film film;
  comm::simulate(simulation, [&](SimulatedRank& self) { play(self, way, from, film); });
  return film;
}

Way way_of(std::uint64_t seed) {
  Way way;
  const int ranks[] = {1, 2, 3, 5, 8};
  const std::uint8_t axes[] = {1, 2, 3, 7, 0};
  way.ranks = ranks[seed % 5];
  way.shared = seed % 3 != 0;
  way.axes = axes[seed / 2 % 5];
  way.births = seed / 3 % 2 == 0 ? frame::Births::calculators : frame::Births::manager;
  way.combine = static_cast<frame::Combine>(seed % 3);
  way.threads = 1 + static_cast<int>(seed / 5 % 2);
  return way;
}

}  // namespace

TEST(a_world_goes_on_from_any_frame_on_any_ranks_with_the_same_bits) {
  // From the second of these numbers on births soon have ids of more than 32 bits.
  const std::uint64_t born[] = {0, (std::uint64_t{1} << 32) - 99};
  Way alone;
  const Film models[] = {run(alone, 0), run((alone.born = born[1], alone), 0)};
  CHECK(models[0].digests.size() == kFrames && models[0].digests.front() != models[0].digests.back());
  CHECK(models[0].digests != models[1].digests);
  for (std::uint64_t seed = 0; seed < 80; ++seed) {
    const Film& model = models[seed / 2 % 2];
    Way way = way_of(seed);
    way.born = born[seed / 2 % 2];
    const Film first = run(way, seed);
    CHECK(first.digests == model.digests);
    const std::size_t frame = seed % (kFrames - 1);
    const Film second = run(way_of(seed * 7 + 3), seed, &first.saved[frame]);
    const std::vector<std::string> rest(model.digests.begin() + static_cast<std::ptrdiff_t>(frame) + 1,
                                        model.digests.end());
    CHECK(second.digests == rest);
  }
}

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
    particles::Bytes planes;
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

TEST(what_all_ranks_know_is_the_same_wherever_particles_are) {
  const Film one = run({}, 0);
  Way way;
  way.ranks = 1;
  way.combine = frame::Combine::one_by_one;
  const Film other = run(way, 1);
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    const auto a = one.saved[frame].shared.view(), b = other.saved[frame].shared.view();
    CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end()));
  }
}

TEST(a_state_of_another_world_is_refused) {
  const Film film = run({}, 0);
  comm::Simulation simulation;
  simulation.ranks = 1;
  comm::simulate(simulation, [&](SimulatedRank& self) {
    frame::Settings settings;
    settings.seed = 5;
    settings.substeps = 2;
    frame::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), roles::cast_shared(1),
                         settings);
    define(engine, {});
    CHECK_THROWS(restore(engine, film.saved[3]), std::runtime_error);
    engine.start();
    engine.finish();
  });
}

TEST(a_part_on_disk_is_the_part_in_memory) {
  Way way;
  way.ranks = 3;
  Film film = run(way, 2);
  Saved& saved = film.saved[5];
  for (auto& [part, description] : saved.descriptions) {
    const particles::Bytes& planes = saved.planes.at(part);
    particles::Bytes file = snapshots::head(description, planes.view());
    file.put_raw(planes.data(), planes.size());
    const snapshots::Opened opened = snapshots::open(file.view(), true);
    particles::Bytes then, now;
    particles::write_fields(description, then);
    particles::write_fields(opened.description, now);
    CHECK(then.size() == now.size() && std::equal(then.data(), then.data() + then.size(), now.data()));
    CHECK(opened.planes.size() == planes.size());
    CHECK_THROWS(snapshots::open(file.view().first(file.size() - 1), false), std::runtime_error);
    file.data()[file.size() - 1] ^= std::byte{1};
    snapshots::open(file.view(), false);
    CHECK_THROWS(snapshots::open(file.view(), true), std::runtime_error);
  }
}

}  // namespace motes::test_snapshots
