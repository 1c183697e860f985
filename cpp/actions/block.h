// The input of a kernel: one block of particles and the parameters of the step. Plain values only.
#pragma once

#include <cstddef>
#include <cstdint>

#include "actions/ageing.h"
#include "actions/numbers.h"
#include "expressions/formula.h"
#include "particles/blocks.h"
#include "particles/ids.h"
#include "particles/periods.h"
#include "particles/streams.h"
#include "shapes/shape.h"

namespace motes::actions {

/// Up to particles::kBlock particles. Kernels process whole vectors: the planes are readable and writable up to the
/// next multiple of particles::kPadding.
struct Block {
  std::size_t count;
  float* const* component;  // one plane per component of the schema, at the block's first particle
  particles::Ids ids;  // from the block's first particle on
  std::uint32_t* dead;  // one bit per particle, set if killed; words begin at the lowest bit
  std::int32_t* hit = nullptr;  // all bits set for particles that bounced; null if not needed
  float stamp = 0;  // of the sub-step, if hits are noted in the columns (hits.h); 0: they are not
};

/// A (sub)step of one action.
struct Step {
  float dt;  // seconds
  std::uint32_t step;  // frame * substeps + substep
  std::uint32_t stream;  // particles::action + the action's place in the list
  alignas(8) particles::Key key;  // aligned to be read in one load
  double time = 0;  // at the start of the step, seconds
  particles::DrawKeys* draws = nullptr;  // for actions that draw
  float start = 0, end = 1;  // the part of the frame that the step covers, for moving shapes
  Ageing ageing{};  // how far ages advance
};

/// The destination of a law's result: the column that it is added to (a rate is multiplied by dt) or replaces.
struct LawResult {
  int component = 0;
  int plane = 0;  // the formula's plane that holds the result
  bool rate = false, adds = false;
};

/// The compiled formula of `law`.
struct LawCode {
  const expressions::FormulaStep* constants = nullptr;
  std::size_t constant_count = 0;
  const expressions::FormulaStep* steps = nullptr;
  std::size_t step_count = 0;
  const LawResult* outcomes = nullptr;
  std::size_t outcome_count = 0;
  std::size_t columns = 0;
  float** plane = nullptr;  // the formula's; the kernel sets those of the columns
};

/// The maximum number of values that an action computes by expressions, other than laws.
inline constexpr int kMostValuesOfAction = 5;

/// The compiled values of `set`, or of an action whose numbers are expressions.
struct ValuesCode {
  int first = 0;  // of `set`: the attribute's first component
  int width = 0;
  const expressions::Instruction* code[kMostValuesOfAction] = {};
  std::size_t length[kMostValuesOfAction] = {};
};

/// Whether `move` turns `up` and orientations.
struct MoveTurns {
  bool up = false, orientation = false;
};

/// A table that a kernel looks up.
struct TableView {
  const float* entries = nullptr;
  int size[3] = {};  // number of entries along each axis
};

/// What kernels of some kinds need beside numbers and shapes. The program sets the member of the action's kind, and its
/// kernel reads no other.
union Bound {
  MoveTurns turns{};
  int ramp;  // number of numbers of its knots
  const ValuesCode* values;
  const LawCode* law;
  const TableView* table;
};

/// The recorded numbers and shapes of the action, and what the program bound to it.
struct Parameters {
  const double* number;
  const shapes::Shape* shape;
  Bound bound{};
  const particles::Periods* periods = nullptr;  // of space
  float* scratch = nullptr;  // for expressions: kScratch floats
};

/// Floats of a plane: one value per particle of a block, with padding.
inline constexpr std::size_t kPlane = particles::kBlock + particles::kPadding;

/// Floats of scratch space: a stack of planes on top of the results before the last.
inline constexpr std::size_t kScratch = (expressions::kDepth + kMostValuesOfAction - 1) * kPlane;

using Kernel = void (*)(const Parameters&, const Block&, const Step&);

}  // namespace motes::actions
