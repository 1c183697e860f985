// Pictures so large that each rank sends its tiles in several messages.
#include <memory>
#include <string>
#include <vector>

#include "check.h"
#include "comm/simulated_ranks.h"
#include "drawn_scene.h"
#include "frame/engine.h"
#include "image/sha256.h"

using namespace motes;
using comm::SimulatedRank;
using Path = image::View::Path;

namespace {

struct Asked {
  int ranks;
  Path path;
  float bloom;  // above 0: sums of light travel, four times as many bytes
};

// The image generator's pictures.
void play(SimulatedRank& self, const Asked& asked, std::vector<std::string>& pictures) {
  auto communicator = std::make_unique<comm::Communicator>(self.transport(), comm::Watch{});
  frame::Engine engine(std::move(communicator), roles::cast_shared(asked.ranks), frame::Settings{});
  test::add_drawn_system(engine);
  image::View view = test::drawn_view(1280, 960, asked.path);
  view.bloom = asked.bloom;
  engine.start();
  for (int i = 0; i < 3; ++i) {
    engine.record(0, test::drawn_source(2000));
    engine.record(0, actions::Action{actions::Kind::move, {1}, {}});
    engine.run_frame(view);
    if (!engine.talk().draws()) continue;
    pictures.push_back(image::picture_sha256(view.width, view.height, engine.painter().take_pixels()));
  }
  engine.finish();
}

std::vector<std::string> pictures_of(const Asked& asked, std::uint64_t seed) {
  std::vector<std::string> pictures;
  comm::Simulation simulation;
  simulation.ranks = asked.ranks;
  simulation.seed = seed;
  comm::simulate(simulation, [&](SimulatedRank& self) { play(self, asked, pictures); });
  return pictures;
}

}  // namespace

TEST(tiles_that_travel_in_several_messages_make_the_same_picture) {
  std::uint64_t seed = 0;
  for (const float bloom : {0.0f, 0.2f}) {
    const std::vector<std::string> alone = pictures_of({1, Path::gather, bloom}, ++seed);
    CHECK(alone.size() == 3 && alone[0] != alone[1] && alone[1] != alone[2]);
    for (const int ranks : {2, 3}) {
      for (const Path path : {Path::tiles, Path::composite}) {
        CHECK(pictures_of({ranks, path, bloom}, ++seed) == alone);
      }
    }
  }
}
