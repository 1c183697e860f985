// All streams of random numbers in the engine. A draw is a pure function of (seed, system, particle id, step, stream,
// draw); it never depends on ranks, order or time.
#pragma once

#include <cstdint>

namespace motes::particles {

/// Births: stream = birth_position, or birth_attribute + the attribute's index; step is 0, since an id is born once.
inline constexpr std::uint32_t birth_position = 1;
inline constexpr std::uint32_t birth_jitter = 2;
inline constexpr std::uint32_t birth_attribute = 0x100;

/// Actions: stream = action + the action's place in the frame's recorded list; step = frame * substeps + substep.
inline constexpr std::uint32_t action = 0x10000;

/// Shape.sample(): independent of every run.
inline constexpr std::uint32_t user_sample = 3;

/// Draws of one stream: at most 16, numbered from 0.
inline constexpr int draw_bits = 4;

/// Rounds of the Philox4x32 that makes keys: the authors' recommendation. Keys are made for blocks of particles, so
/// their cost does not matter.
inline constexpr int philox_rounds = 10;

/// The key of one system's draws.
struct Key {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
};

/// Mixes the 64-bit seed with the system's index.
Key system_key(std::uint64_t seed, std::uint32_t system);

}  // namespace motes::particles
