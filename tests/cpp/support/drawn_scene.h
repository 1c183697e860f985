// A scene for tests of pictures that ranks draw together: a box of particles in front of the camera.
#pragma once

#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "image/scene.h"

namespace test {

/// Adds one system, whose space is as wide as the box.
inline void add_drawn_system(motes::engine::Engine& engine) {
  motes::recording::SystemDefinition definition;
  definition.space = {motes::domains::Space::Kind::finite, -4, 4};
  engine.add_system(definition);
}

inline motes::image::View drawn_view(int width, int height, motes::image::View::Path path) {
  motes::image::View view;
  view.width = width;
  view.height = height;
  view.camera.position = {0, 0, 8};
  view.path = path;
  return view;
}

/// Returns a source all over the box that emits this many particles per frame of 1/24 s.
inline motes::recording::Source drawn_source(double per_frame) {
  motes::recording::Source source;
  source.shape = {motes::shapes::Kind::box, {-4, -3, -1, 4, 3, 1}};
  source.rate = 24 * per_frame;
  return source;
}

/// Runs `play` on this many simulated ranks, in an order of events that the seed determines.
template <class Play>
void on_ranks(int ranks, std::uint64_t seed, const Play& play) {
  motes::comm::Simulation simulation;
  simulation.ranks = ranks;
  simulation.seed = seed;
  motes::comm::simulate(simulation, play);
}

}  // namespace test
