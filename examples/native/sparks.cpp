// Flying sparks in C++, using the engine without Python. docs/native.md shows how to build and run this program.
#include <cstdio>
#include <memory>

#include "base/sha256.h"
#include "comm/environment.h"
#include "comm/mpi_transport.h"
#include "engine/engine.h"

using namespace motes;

namespace {

shapes::Shape disc() { return {shapes::Kind::disc, {0, 0.1f, 0, 0, 1, 0, 0.5f, 0}}; }
shapes::Shape sphere(float x, float y, float z, float radius) { return {shapes::Kind::sphere, {x, y, z, radius}}; }
shapes::Shape ground() { return {shapes::Kind::plane, {0, 0, 0, 0, 1, 0}}; }

// Records the calls that a script would record in each frame.
void record_frame(engine::Engine& engine, int sparks) {
  recording::Source source;
  source.shape = disc();
  source.rate = 24 * 500;
  const actions::distributions::InShape upwards{sphere(0, 5, 0, 1.5f)};
  source.state = {{particles::velocity, upwards}};
  engine.record(sparks, source);
  namespace numbers = actions::numbers;
  const numbers::bounce<> rebound{.restitution = 0.5, .friction = 0.1, .exact_hit = 1};
  engine.record(sparks, actions::make(numbers::gravity<>{.acceleration = {0, -9.81, 0}}));
  engine.record(sparks, actions::make(rebound, {ground()}));
  engine.record(sparks, actions::make(numbers::kill_old<>{.age_limit = 2}));
  engine.record(sparks, actions::make(numbers::move<>{.rotational = 1}));
}

image::View view() {
  image::View view;
  view.width = 320;
  view.height = 180;
  view.camera.position = {0, 1.5, 6};
  view.camera.look_at = {0, 1, 0};
  view.objects = {{ground(), {0.02f, 0.02f, 0.03f}}};
  return view;
}

}  // namespace

[[gnu::visibility("default")]] int main(int argc, char** argv) {
  const comm::Environment mpi(argc, argv);
  auto communicator = std::make_unique<comm::Communicator>(comm::make_mpi(mpi.world()), comm::Watch{});
  engine::Settings settings;
  settings.seed = 1;
  engine::Engine engine(std::move(communicator), roles::cast_auto(mpi.size()), settings);
  recording::SystemDefinition definition;
  definition.name = "sparks";
  definition.space = {domains::Space::Kind::finite, -4, 4};
  const int sparks = engine.add_system(definition);
  const image::View shown = view();
  try {
    engine.start();
    for (int i = 0; i < 24; ++i) {
      record_frame(engine, sparks);
      engine.run_frame(shown);
      if (!engine.session().draws()) continue;
      const std::string sum = base::picture_sha256(shown.width, shown.height, engine.painter().take_pixels());
      std::printf("frame %d: %llu particles, picture %s\n", i,
                  static_cast<unsigned long long>(engine.system(sparks).counts.alive), sum.c_str());
    }
    engine.finish();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sparks: rank %d: %s\n", mpi.rank(), error.what());
    mpi.abort(1);
  }
}
