// Small animations for simulated ranks, and the ways to play them: on how many ranks, in which roles, with which
// domains. The result does not depend on the way.
#pragma once

#include <cstdint>
#include <optional>

#include "comm/simulated_machine.h"
#include "engine/engine.h"

namespace motes::soak {

using comm::simulation::Random;

constexpr std::uint64_t kFrames = 16;
constexpr int kWidth = 80, kHeight = 64;  // two tiles

/// What is played: equal for all ways.
struct Story {
  bool reads = false;  // whether particles are read within frames
  bool sub_steps = false;  // two per frame; particles are not read then
  bool meets = false;  // particles collide
  bool pictures = false;
  bool streaks = false;

  auto operator<=>(const Story&) const = default;
};

/// How it is played.
struct Way {
  int ranks = 1;
  roles::Cast cast;
  std::uint8_t axes = 1;
  engine::Combine combine = engine::Combine::together;
  engine::Births births = engine::Births::manager;
  int threads = 1;
  int fan_out = 8;
  int balancer = 0;  // none, pairwise, diffusive, prefix cuts
  image::View::Path path = image::View::Path::automatic;
};

Story random_story(Random& random);
Way random_way(Random& random);

engine::Settings settings(const Story& story, const Way& way);
/// Adds the systems: parents, and the children that are born where they hit the ground.
void define(engine::Engine& engine, const Way& way);
/// Records the list of a frame.
void record(engine::Engine& engine, const Story& story, std::uint64_t frame);
std::optional<image::View> view(const Story& story, const Way& way, std::uint64_t frame);

}  // namespace motes::soak
