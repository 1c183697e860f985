// What a kernel sees: one block of particles and the facts of the step. Plain values only.
#pragma once

#include <cstddef>
#include <cstdint>

#include "actions/ageing.h"
#include "actions/numbers.h"
#include "expressions/formula.h"
#include "particles/blocks.h"
#include "particles/ids.h"
#include "particles/streams.h"
#include "shapes/shape.h"

namespace motes::actions {

/// Up to particles::kBlock particles. Kernels process whole vectors: the planes are readable and writable up to the
/// next multiple of particles::kPadding.
struct Block {
  std::size_t count;
  float* const* component;   // one plane per component of the schema, at the block's first particle
  particles::Ids ids;        // from the block's first particle on
  std::uint32_t* dead;       // a bit per particle, set where it was killed; the first one's is the lowest of a word
  std::int32_t* hit = nullptr;  // all bits set where a particle bounced; null where nobody needs it
};

/// A (sub)step of one action.
struct Step {
  float dt;                  // seconds
  std::uint32_t step;        // frame * substeps + substep
  std::uint32_t stream;      // particles::action + the action's place in the list
  alignas(8) particles::Key key;  // read at once
  double time = 0;           // at the start of the step, seconds
  particles::DrawKeys* draws = nullptr;  // for actions that draw
  float start = 0, end = 1;  // which part of the frame it is: for shapes that move
  Ageing ageing{};           // for move
};

/// A result of a law: the column that it is added to (a rate times dt), or whose place it takes.
struct LawResult {
  int component = 0;
  int plane = 0;  // of the formula
  bool rate = false, adds = false;
};

/// law: what it computes for each particle.
struct LawCode {
  const expressions::FormulaStep* constants = nullptr;
  std::size_t constant_count = 0;
  const expressions::FormulaStep* steps = nullptr;
  std::size_t step_count = 0;
  const LawResult* outcomes = nullptr;
  std::size_t outcome_count = 0;
  std::size_t columns = 0;
  float** plane = nullptr;  // the formula's: those of the columns are the kernel's to say
};

/// The recorded numbers and shapes of the action.
struct Parameters {
  const double* number;
  const shapes::Shape* shape;
  int numbers = 0;
  bool flag = false;         // move: whether `up` turns
  bool spins = false;        // move: whether orientations turn
  int target = 0;            // set: the attribute's first component, its width, and its compiled values
  int width = 0;
  const expressions::Instruction* code[4] = {};
  std::size_t length[4] = {};
  const LawCode* law = nullptr;  // law: what it computes
  const float* table = nullptr;  // its entries, of known width, and how many there are along each axis
  int table_size[3] = {};
  float* scratch = nullptr;  // for expressions: kScratch floats
};

/// A value for each particle of a block takes so many floats.
inline constexpr std::size_t kPlane = particles::kBlock + particles::kPadding;

/// A stack of block-wide values, on top of up to three results that are kept.
inline constexpr std::size_t kScratch = (expressions::kDepth + 3) * kPlane;

using Kernel = void (*)(const Parameters&, const Block&, const Step&);

}  // namespace motes::actions
