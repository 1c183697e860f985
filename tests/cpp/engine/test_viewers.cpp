// Orders of viewers reach all ranks before the next frame, and a picture between two frames changes nothing.
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"
#include "support/falling_source.h"

namespace motes::test_viewers {
using comm::SimulatedRank;

namespace {

struct Asked {
  int ranks = 1;
  bool shared = false;
  bool apart = false;  // the image generator is a calculator, the manager another rank
  int fan_out = 8;
  engine::Combine combine = engine::Combine::together;
  bool redraws = false;
  float shutter = 0;
};

// What one rank received and saw.
struct End {
  std::vector<std::string> heard;  // after each frame and each question between frames
  int asked = 0;  // how often the image generator's function was called
  std::vector<particles::Digest> particles;
  std::vector<image::Pixels> pictures;
};

roles::Cast cast_of(const Asked& asked) {
  if (asked.apart && asked.ranks > 1) {
    roles::Cast cast = roles::cast_shared(asked.ranks);
    cast.image_generator = asked.ranks - 1;
    return cast;
  }
  return asked.shared ? roles::cast_shared(asked.ranks) : roles::cast_auto(asked.ranks);
}

image::View view_of(const Asked& asked, double x) {
  image::View view;
  view.width = 96;
  view.height = 64;
  view.camera.position = {x, 0, 12};
  view.shutter = asked.shutter;
  return view;
}

void redraw_twice(engine::Engine& engine, const Asked& asked, double x, End& end) {
  const bool draws = engine.session().draws();
  image::Pixels last = engine.painter().take_pixels();
  engine.redraw(view_of(asked, x));
  if (draws && asked.shutter == 0) CHECK(engine.painter().take_pixels() == last);
  engine.redraw(view_of(asked, x + 3));
  if (draws) CHECK(engine.painter().take_pixels() != last);
  if (draws) end.pictures.push_back(std::move(last));
}

End play(SimulatedRank& self, const Asked& asked) {
  const roles::Cast cast = cast_of(asked);
  engine::Settings settings;
  settings.costs.act.fill(1000);
  settings.fan_out = asked.fan_out;
  settings.combine = asked.combine;
  engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), cast, settings);
  End end;
  engine.on_orders(
      [&] { return "order " + std::to_string(end.asked++); });  // never called on ranks other than the image generator
  recording::SystemDefinition definition;
  definition.space = {domains::Space::Kind::finite, -4, 4};
  for (const char* name : {"a", "b"}) {
    definition.name = name;
    engine.add_system(definition);
  }
  engine.start();
  for (int frame = 0; frame < 5; ++frame) {
    for (int system = 0; system < 2; ++system) {
      engine.record(system, test::falling_source(30));
      engine.record(system, actions::make(actions::numbers::move<>{.rotational = 1}));
    }
    const double x = 0.5 * frame;  // the shutter sees the camera move
    engine.run_frame(view_of(asked, x));
    end.heard.push_back(engine.orders());
    if (asked.redraws) {
      redraw_twice(engine, asked, x, end);
      CHECK(engine.orders() == end.heard.back());  // a picture adds none and forgets none
    } else if (engine.session().draws()) {
      end.pictures.push_back(engine.painter().take_pixels());
    }
    if (frame % 2 == 0) {
      engine.hear_orders();
      end.heard.push_back(engine.orders());
    }
  }
  end.particles = engine.digest();
  engine.finish();
  return end;
}

std::map<int, End> ends_of(const Asked& asked, std::uint64_t seed) {
  std::map<int, End> ends;
  for (int rank = 0; rank < asked.ranks; ++rank) ends[rank] = {};
  comm::simulate({.ranks = asked.ranks, .seed = seed},
                 [&](SimulatedRank& self) { ends[self.rank()] = play(self, asked); });
  return ends;
}

Asked variant(std::uint64_t seed) {
  Asked asked;
  asked.ranks = 1 + static_cast<int>(seed % 7);
  asked.shared = seed % 2 == 0;
  asked.apart = seed % 3 == 0;
  asked.fan_out = 1 + static_cast<int>(seed % 3);
  asked.combine = static_cast<engine::Combine>(seed / 2 % 3);
  return asked;
}

}  // namespace

TEST(all_ranks_hear_what_the_image_generator_was_asked_once_per_frame) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Asked asked = variant(seed);
    const auto ends = ends_of(asked, seed);
    std::vector<std::string> expected;
    for (int i = 0; i < 8; ++i) expected.push_back("order " + std::to_string(i));
    const int home = cast_of(asked).image_generator;
    for (const auto& [rank, end] : ends) {
      CHECK(end.heard == expected);
      CHECK(end.asked == (rank == home ? 8 : 0));
    }
  }
}

TEST(pictures_between_frames_change_nothing) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Asked asked = variant(seed);
    asked.shutter = seed % 2 == 0 ? 0.0f : 0.5f;
    const auto plain = ends_of(asked, seed);
    asked.redraws = true;
    const auto drawn = ends_of(asked, seed + 1000);
    for (const auto& [rank, end] : plain) {
      CHECK(end.particles == drawn.at(rank).particles);
      CHECK(end.pictures == drawn.at(rank).pictures);  // also the next frame's, whose shutter knows the last camera
    }
  }
}

TEST(a_picture_of_half_a_frame_is_refused) {
  bool refused = false;
  comm::simulate({}, [&](SimulatedRank& self) {
    engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), roles::cast_auto(1),
                          {});
    engine.add_system({});
    engine.start();
    engine.record(0, test::falling_source(30));
    engine.redraw(view_of({}, 0));  // the list has not run yet
    engine.local(0);
    try {
      engine.redraw(view_of({}, 0));
    } catch (const std::invalid_argument&) {
      refused = true;
    }
    engine.run_frame(std::nullopt);
    engine.finish();
  });
  CHECK(refused);
}

}  // namespace motes::test_viewers
