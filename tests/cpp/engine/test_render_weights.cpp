// What pictures cost on simulated machines: each computed particle may stand for many, and so may its records.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "comm/clock.h"
#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "engine/render/render_costs.h"
#include "support/check.h"
#include "support/drawn_scene.h"
#include "support/forwarding_transport.h"

namespace motes::test_render_weights {
using comm::Phase;
using comm::SimulatedRank;
using Path = image::View::Path;

namespace {

constexpr double kScale = 100, kMessage = 700, kByte = 3;  // operations

// A message of records or partial tiles, at its sender.
struct Sent {
  double bytes = 0, operations = 0;
};

class Watching final : public test::Forwarding {
 public:
  Watching(std::unique_ptr<Transport> under, std::vector<Sent>& sent) : Forwarding(std::move(under)), sent_(sent) {}
  void send(int to, Phase phase, std::shared_ptr<const comm::Message> message) override {
    const auto bytes = static_cast<double>(message->bytes().size());
    const double before = comm::wall_seconds();
    Forwarding::send(to, phase, std::move(message));
    if (phase == Phase::records) sent_.push_back({bytes, (comm::wall_seconds() - before) * 1e9});
  }

 private:
  std::vector<Sent>& sent_;
};

// Returns what calculators send for the pictures of a few frames.
std::vector<Sent> sent_on(Path path) {
  std::vector<Sent> sent;
  comm::simulate({.ranks = 4, .variation = 0}, [&](SimulatedRank& self) {
    engine::Settings settings;
    settings.costs.messages = {kScale, kMessage, kByte};
    engine::Engine engine(
        std::make_unique<comm::Communicator>(std::make_unique<Watching>(self.transport(), sent), comm::Watch{}),
        roles::cast_shared(4), std::move(settings));
    test::add_drawn_system(engine);
    const image::View view = test::drawn_view(200, 150, path);
    engine.start();
    for (int i = 0; i < 3; ++i) {
      engine.record(0, test::drawn_source(300));
      engine.record(0, actions::Action{actions::Kind::random_displacement, {}, {{shapes::Kind::sphere, {0, 0, 0, 1}}}});
      engine.record(0, actions::make(actions::numbers::move<>{.rotational = 1}));
      engine.run_frame(view);
    }
    engine.finish();
  });
  return sent;
}

// The maximum bytes of a message for tiles that no particle touches.
constexpr double kEmpty = 150;

bool weighs(const Sent& one, double scale) {
  const double expected = kMessage + kByte * one.bytes * scale;
  return std::fabs(one.operations - expected) < 1e-3 * expected;
}

}  // namespace

TEST(records_weigh_as_many_as_they_stand_for_and_partial_tiles_their_bytes) {
  const std::vector<Sent> records = sent_on(Path::tiles), partial = sent_on(Path::composite);
  const auto full = [](const Sent& one) { return one.bytes > kEmpty; };
  CHECK(std::any_of(records.begin(), records.end(), full) && std::any_of(partial.begin(), partial.end(), full));
  for (const Sent& one : records) CHECK(weighs(one, full(one) ? kScale : 1));
  for (const Sent& one : partial) CHECK(weighs(one, 1));
}

namespace {

// Returns the simulated seconds of a frame whose picture takes a second without bloom; nothing else has costs.
double frame_s(int ranks, Path path, float bloom) {
  double seconds = 0;
  comm::simulate({.ranks = ranks, .variation = 0}, [&](SimulatedRank& self) {
    engine::Settings settings;
    settings.costs.picture = 1e9;
    engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}),
                          roles::cast_shared(ranks), std::move(settings));
    test::add_drawn_system(engine);
    image::View view = test::drawn_view(1024, 768, path);
    view.bloom = bloom;
    engine.start();
    for (int i = 0; i < 3; ++i) {
      const double start = comm::wall_seconds();
      engine.record(0, test::drawn_source(10));
      engine.run_frame(view);
      if (engine.session().draws()) seconds = comm::wall_seconds() - start;
    }
    engine.finish();
  });
  return seconds;
}

}  // namespace

TEST(bloom_takes_simulated_ranks_what_it_takes_others) {
  namespace costs = engine::render_costs;
  const double pixel = costs::kBloomPixel / costs::kPixel, spread = costs::kSpreadPixel / costs::kPixel;
  CHECK_NEAR(frame_s(1, Path::gather, 0), 1, 1e-3);
  CHECK_NEAR(frame_s(1, Path::gather, 0.2f), 1 + pixel + spread, 1e-3);
  const double light = frame_s(2, Path::tiles, 0), glowing = frame_s(2, Path::tiles, 0.2f);
  CHECK(light >= 0.5 && light < 0.65);  // one rank draws somewhat more than the other
  CHECK(glowing - spread >= 0.5 * (1 + pixel) && glowing - spread < 0.65 * (1 + pixel));
}

}  // namespace motes::test_render_weights
