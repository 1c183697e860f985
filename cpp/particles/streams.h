// All streams of random numbers in the engine. A draw is a pure function of (seed, system, particle id, step, stream,
// draw); it never depends on ranks, order or time.
#pragma once

#include <cstdint>

#include "particles/schema.h"

namespace motes::particles {

/// Births: stream = birth_position, or birth_stream(attribute); step is 0, since an id is born once.
inline constexpr std::uint32_t birth_position = 1;
inline constexpr std::uint32_t birth_jitter = 2;
inline constexpr std::uint32_t birth_attribute = 0x100;
constexpr std::uint32_t birth_stream(int attribute) {
  // Orientation and spin come before the users' attributes but do not change their streams.
  constexpr int kMoved = builtin_count - orientation;
  const int index = attribute < orientation     ? attribute
                    : attribute < builtin_count ? 0x80 + attribute
                                                : attribute - kMoved;
  return birth_attribute + static_cast<std::uint32_t>(index);
}

/// Actions: stream = action + the action's place in the frame's recorded list; step = frame * substeps + substep.
inline constexpr std::uint32_t action = 0x10000;

/// Shape.sample(): independent of every run.
inline constexpr std::uint32_t user_sample = 3;

/// Which tile of a sheet a particle shows; step is 0.
inline constexpr std::uint32_t sprite_tile = 4;

/// Draws of one stream: at most 16, numbered from 0.
inline constexpr int draw_bits = 4;

/// Returns the number of a draw that is repeated because the previous attempt was rejected; at most 65535 times.
constexpr std::uint32_t made_again(std::uint32_t draw, std::uint32_t attempt) { return draw | attempt << 16; }

/// The key of one system's draws.
struct Key {
  std::uint32_t low = 0;
  std::uint32_t high = 0;

  bool operator==(const Key&) const = default;
};

/// Mixes the 64-bit seed with the system's index.
Key system_key(std::uint64_t seed, std::uint32_t system);

/// What the words of one draw depend on besides the particle's id.
struct DrawKey {
  std::uint32_t word[8];
};

/// Computes the key of a draw with Philox.
DrawKey draw_key(Key key, std::uint32_t step, std::uint32_t stream, std::uint32_t draw);

/// The keys of one stream's draws in one step, kept from block to block.
class DrawKeys {
 public:
  /// Makes the first draw's key, unless it is the one made last.
  void begin(Key key, std::uint32_t step, std::uint32_t stream) {
    if (step != step_ || stream != stream_ || key != key_) make_first(key, step, stream);
  }
  const DrawKey& first() const { return first_; }

  /// Returns the key of draw number `draw`, from 1.
  const DrawKey& later(std::uint32_t draw);

 private:
  void make_first(Key key, std::uint32_t step, std::uint32_t stream);

  Key key_;
  std::uint32_t step_ = 0, stream_ = 0;  // no stream has the number 0
  DrawKey first_{};
  DrawKey later_{};               // of draw `later_draw_`
  std::uint32_t later_draw_ = 0;  // 0: none
};

}  // namespace motes::particles
