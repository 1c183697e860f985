// Pictures so large that each rank sends its tiles in several messages, which travel while ranks compute.
#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/sha256.h"
#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"
#include "support/drawn_scene.h"
#include "support/forwarding_transport.h"

namespace motes::test_render_parcels {
using comm::SimulatedRank;
using Path = image::View::Path;

namespace {

struct Asked {
  int ranks;
  Path path;
  float bloom = 0;
  bool linear = false;  // sums of light travel: four times as many bytes
};

// The image generator's pictures, and what all ranks asked of their transports.
struct Seen {
  std::vector<std::string> pictures;
  int in_records = 0, in_frames = 0;  // calls of progress(), of all ranks
  int awaited = 0;                    // messages of tiles from one rank, at most
};

class Watched : public test::Forwarding {
 public:
  Watched(std::unique_ptr<Transport> under, int& calls, int& awaited)
      : Forwarding(std::move(under)), calls_(calls), awaited_(awaited) {}
  void progress() noexcept override { ++calls_; }
  void await(int from, Phase phase, int messages) override {
    if (phase == Phase::tiles) awaited_ = std::max(awaited_, messages);
    Forwarding::await(from, phase, messages);
  }

 private:
  int& calls_;
  int& awaited_;
};

void play(SimulatedRank& self, const Asked& asked, Seen& seen) {
  int calls = 0, awaited = 0;
  auto transport = std::make_unique<Watched>(self.transport(), calls, awaited);
  auto communicator = std::make_unique<comm::Communicator>(std::move(transport), comm::Watch{});
  engine::Engine engine(std::move(communicator), roles::cast_shared(asked.ranks), engine::Settings{});
  test::add_drawn_system(engine);
  image::View view = test::drawn_view(1280, 960, asked.path);
  view.bloom = asked.bloom;
  view.linear = asked.linear;
  engine.start();
  for (int i = 0; i < 3; ++i) {
    calls = 0;
    engine.record(0, test::drawn_source(2000));
    engine.record(0, actions::make(actions::numbers::move<>{.rotational = 1}));
    const int recorded = calls;
    engine.run_frame(view);
    seen.in_records += recorded;
    seen.in_frames += calls - recorded;
    seen.awaited = std::max(seen.awaited, awaited);
    if (!engine.session().draws()) continue;
    seen.pictures.push_back(base::picture_sha256(view.width, view.height, engine.painter().take_pixels()));
    if (!view.linear) continue;
    const std::vector<float> linear = engine.painter().linear();
    base::Sha256 digest;
    digest.add(std::as_bytes(std::span(linear)));
    seen.pictures.push_back(digest.finish());
  }
  engine.finish();
}

Seen seen_of(const Asked& asked, std::uint64_t seed) {
  Seen seen;
  test::on_ranks(asked.ranks, seed, [&](SimulatedRank& self) { play(self, asked, seen); });
  return seen;
}

}  // namespace

TEST(tiles_that_travel_in_several_messages_make_the_same_picture) {
  std::uint64_t seed = 0;
  for (const float bloom : {0.0f, 0.2f}) {
    for (const bool linear : {false, true}) {
      const std::vector<std::string> alone = seen_of({1, Path::gather, bloom, linear}, ++seed).pictures;
      CHECK(alone.size() == (linear ? 6u : 3u) && alone[0] != alone[1] && alone[1] != alone[2]);
      for (const int ranks : {2, 3}) {
        if (ranks == 2 && linear != (bloom > 0)) continue;
        for (const Path path : {Path::tiles, Path::composite}) {
          CHECK(seen_of({ranks, path, bloom, linear}, ++seed).pictures == alone);
        }
      }
    }
  }
}

TEST(messages_travel_while_a_rank_records_acts_and_draws) {
  const int tiles = image::Grid{1280, 960}.tiles();
  for (const int ranks : {1, 2, 3}) {
    const Seen seen = seen_of({ranks, Path::tiles, 0}, 1);
    CHECK(seen.in_records == 3 * 2 * ranks);
    CHECK(seen.in_frames > 3 * tiles);  // one after each tile, on the rank that draws it
    CHECK((seen.awaited > 1) == (ranks > 1));
  }
}

}  // namespace motes::test_render_parcels
