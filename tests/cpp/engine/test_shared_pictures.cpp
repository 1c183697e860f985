// Pictures in memory that the ranks of a host share: the same pixels, whatever pictures a script still holds.
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include "base/sha256.h"
#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"
#include "support/drawn_scene.h"
#include "support/forwarding_transport.h"

namespace motes::test_shared_pictures {
using comm::SimulatedRank;
using engine::SharedPictures;
using Path = image::View::Path;

namespace {

struct Asked {
  int ranks = 2;
  bool shared_roles = true;
  Path path = Path::tiles;
  float bloom = 0;
  bool linear = false;       // the memory holds sums of light, not pixels
  std::uint8_t layers = 0;
  std::vector<int> widths = {640, 640, 640, 640};  // of each frame's picture
  bool held = false;  // the script holds all pictures
  bool redrawn = false;  // each picture is drawn once more, from elsewhere
  bool refused = false;  // the image generator refuses shared memory
  int refused_by = -1;  // the rank that refuses it
};

struct Seen {
  std::vector<std::string> pictures;
  std::vector<std::uint64_t> bytes;  // of messages of tiles, per frame
  int told = 0;                      // messages that say where the memory is
};

// A transport that presents ranks as processes, although they are threads of one.
class OfProcesses : public test::Forwarding {
 public:
  OfProcesses(std::unique_ptr<Transport> under, std::uint64_t& bytes, int& told)
      : Forwarding(std::move(under)), bytes_(bytes), told_(told) {}
  bool between_processes() const override { return true; }
  void send(int to, Phase phase, std::shared_ptr<const comm::Message> message) override {
    if (phase == Phase::tiles) bytes_ += message->payload().size();
    told_ += phase == Phase::memory ? 1 : 0;
    Forwarding::send(to, phase, std::move(message));
  }

 private:
  std::uint64_t& bytes_;
  int& told_;
};

void play(SimulatedRank& self, const Asked& asked, Seen& seen) {
  std::uint64_t bytes = 0;
  engine::Settings settings;
  const roles::Cast cast = asked.shared_roles ? roles::cast_shared(asked.ranks) : roles::cast_auto(asked.ranks);
  const bool draws = self.rank() == cast.image_generator;
  settings.shares_pictures = draws ? !asked.refused : self.rank() != asked.refused_by;
  auto transport = std::make_unique<OfProcesses>(self.transport(), bytes, seen.told);
  auto communicator = std::make_unique<comm::Communicator>(std::move(transport), comm::Watch{});
  engine::Engine engine(std::move(communicator), cast, std::move(settings));
  test::add_drawn_system(engine);
  engine.start();
  seen.bytes.resize(asked.widths.size());
  std::vector<image::Pixels> held;
  for (std::size_t i = 0; i < asked.widths.size(); ++i) {
    image::View view = test::drawn_view(asked.widths[i], asked.widths[i] * 3 / 4, asked.path);
    view.bloom = asked.bloom;
    view.linear = asked.linear;
    view.layers = asked.layers;
    bytes = 0;
    engine.record(0, test::drawn_source(500));
    engine.record(0, actions::make(actions::numbers::move<>{.rotational = 1}));
    engine.run_frame(view);
    seen.bytes[i] += bytes;
    if (asked.redrawn) {
      if (draws) held.push_back(engine.painter().take_pixels());
      view.camera.position[0] = 1;
      engine.redraw(view, "");
    }
    if (!draws) continue;
    if (asked.held || asked.redrawn) {
      held.push_back(engine.painter().take_pixels());
    } else {
      seen.pictures.push_back(base::picture_sha256(view.width, view.height, engine.painter().take_pixels()));
    }
    for (int bit = 1; bit <= asked.layers; bit *= 2) {
      const std::vector<float>& layer = engine.painter().layer(static_cast<std::uint8_t>(bit));
      base::Sha256 digest;
      digest.add(std::as_bytes(std::span(layer)));
      seen.pictures.push_back(digest.finish());
    }
  }
  for (const image::Pixels& pixels : held) seen.pictures.push_back(base::picture_sha256(640, 480, pixels));
  engine.finish();
}

Seen seen_of(const Asked& asked, std::uint64_t seed = 1) {
  Seen seen;
  test::on_ranks(asked.ranks, seed, [&](SimulatedRank& self) { play(self, asked, seen); });
  return seen;
}

Seen alone(Asked asked) {
  asked.ranks = 1;
  asked.path = Path::gather;
  return seen_of(asked);
}

// More bytes than messages about tiles whose pixels are in shared memory.
constexpr std::uint64_t kPixels = 20'000;

}  // namespace

TEST(pictures_in_shared_memory_are_the_same_and_no_pixels_travel) {
  std::uint64_t seed = 0;
  for (const auto& [bloom, linear] : {std::pair{0.0f, false}, {0.2f, false}, {0.0f, true}, {0.2f, true}}) {
    const Seen one = alone({.bloom = bloom, .linear = linear});
    CHECK(one.pictures.size() == 4 && one.told == 0);
    for (const int ranks : {2, 3, 5}) {
      if (ranks != 3 && linear != (bloom > 0)) continue;
      for (const bool shared_roles : {true, false}) {
        for (const Path path : {Path::tiles, Path::composite}) {
          const Seen seen = seen_of(
              {.ranks = ranks, .shared_roles = shared_roles, .path = path, .bloom = bloom, .linear = linear}, ++seed);
          CHECK(seen.pictures == one.pictures);
          CHECK(seen.told >= 1 && seen.told <= ranks - 1);
        }
      }
      const Seen together = seen_of({.ranks = ranks, .bloom = bloom, .linear = linear}, ++seed);
      for (const std::uint64_t bytes : together.bytes) CHECK(bytes < kPixels);
    }
  }
}

TEST(layers_travel_beside_pixels_in_shared_memory) {
  constexpr std::uint8_t kDepthAndAlpha = image::kDepthLayer | image::kAlphaLayer;
  for (const float bloom : {0.0f, 0.2f}) {
    for (const bool linear : {false, true}) {
      const Seen one = alone({.bloom = bloom, .linear = linear, .layers = kDepthAndAlpha});
      CHECK(one.pictures.size() == 12);
      const Seen seen = seen_of({.ranks = 3, .bloom = bloom, .linear = linear, .layers = kDepthAndAlpha});
      CHECK(seen.pictures == one.pictures);
    }
  }
}

TEST(who_cannot_reach_the_memory_sends_pixels) {
  const Seen one = alone({});
  const Seen refused = seen_of({.ranks = 3, .refused = true}), by_one = seen_of({.ranks = 3, .refused_by = 1});
  CHECK(refused.pictures == one.pictures && by_one.pictures == one.pictures);
  CHECK(by_one.bytes.back() > kPixels && refused.bytes.back() > by_one.bytes.back());
}

TEST(pictures_that_the_script_holds_are_not_drawn_into_again) {
  const std::vector<int> widths(SharedPictures::kPictures + 3, 640);
  const Seen one = alone({.widths = widths});
  const Seen held = seen_of({.widths = widths, .held = true});
  CHECK(held.pictures == one.pictures);
  CHECK(held.bytes[SharedPictures::kPictures - 1] < kPixels);
  CHECK(held.bytes[SharedPictures::kPictures] > kPixels);  // no picture is left
}

TEST(a_picture_that_is_drawn_again_leaves_the_first_one_alone) {
  const std::vector<int> widths(2, 640);
  const Seen one = alone({.widths = widths, .redrawn = true});
  CHECK(one.pictures.size() == 4 && one.pictures[0] != one.pictures[1]);
  for (const bool shared_roles : {true, false}) {
    CHECK(seen_of({.ranks = 3, .shared_roles = shared_roles, .widths = widths, .redrawn = true}).pictures ==
          one.pictures);
  }
}

TEST(memory_grows_with_the_pictures_and_serves_smaller_ones) {
  const std::vector<int> widths = {320, 640, 320, 640, 800, 800, 64};
  const Seen one = alone({.widths = widths});
  for (const int ranks : {2, 3}) {
    const Seen seen = seen_of({.ranks = ranks, .widths = widths});
    CHECK(seen.pictures == one.pictures);
    CHECK(seen.told == 3 * (ranks - 1));
    for (const std::uint64_t bytes : seen.bytes) CHECK(bytes < kPixels);
  }
}

TEST(a_picture_that_a_child_process_still_sees_stays_as_it_is) {
  test::on_ranks(2, 1, [&](SimulatedRank& self) {
    std::uint64_t bytes = 0;
    int told = 0;
    auto transport = std::make_unique<OfProcesses>(self.transport(), bytes, told);
    engine::Engine engine(std::make_unique<comm::Communicator>(std::move(transport), comm::Watch{}),
                          roles::cast_shared(2), engine::Settings{});
    test::add_drawn_system(engine);
    engine.start();
    engine.record(0, test::drawn_source(500));
    engine.run_frame(test::drawn_view(640, 480, Path::tiles));
    if (engine.session().draws()) {
      SharedPictures& shared = engine.painter().shared;
      const auto open = [&] { return shared.open(3 * 640 * 480, {}); };
      std::shared_ptr<std::uint8_t[]> free = open();
      const std::uint8_t* const place = free.get();
      free.reset();
      CHECK(open().get() == place);  // nothing holds it any more
      free = open();
      const pid_t child = ::fork();
      if (child == 0) ::_exit(0);
      CHECK(::waitpid(child, nullptr, 0) == child);
      free.reset();
      const auto next = open();
      CHECK(next && next.get() != place);
    }
    engine.finish();
  });
}

}  // namespace motes::test_shared_pictures
