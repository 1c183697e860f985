// The kernels of all actions and births, compiled for this processor's instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "actions/action.h"
#include "actions/block.h"
#include "actions/distribution.h"

namespace motes::actions {

/// Particles with low <= x < high stay.
struct Band {
  const float* x = nullptr;  // a plane of coordinates, from the block's first particle on
  float low = 0, high = 0;
};

struct Kernels {
  Kernel action[kKinds];

  /// Runs a checked expression over a block at `time` (seconds); the result is at the start of `stack` (kScratch
  /// floats).
  void (*evaluate)(const expressions::Instruction* code, std::size_t length, const shapes::Shape* shapes, const Block&,
                   float time, float* stack);

  /// Draws an attribute of `width` (1, 3 or 4) numbers for `count` particles into planes with room for whole vectors.
  /// step.stream selects the stream. `birthplace`: the mesh whose surface gives normals and colours; else unused.
  void (*draw)(const Distribution&, const shapes::Shape* birthplace, const Step&, const particles::Ids&,
               std::size_t count, float* const* planes, int width);

  /// Jitters births, as if a random fraction u of the step had passed: x += v u dt, age += u dt.
  void (*jitter)(const Block&, const Step&);

  /// Spreads births along the path of a moving shape: x = before + (x - before) (end - (end - start) u), with u random.
  void (*spread)(const Block& positions, float* const* before, float start, float end, const Step&);

  /// inside[i] = whether the shape contains particle i.
  void (*contains)(const shapes::Shape&, const float* const* position, std::size_t count, std::uint8_t* inside);

  /// Writes the indices of dead particles to `dead`, and of living particles outside at least one of up to three bands
  /// to `left`. Indices count from `base`. Each array has room for kPadding more indices than there are particles.
  void (*collect)(const Block&, const Band* bands, std::size_t band_count, std::uint32_t base, std::uint32_t* dead,
                  std::size_t& dead_count, std::uint32_t* left, std::size_t& left_count);
};

const Kernels& kernels();

}  // namespace motes::actions
