// Working memory of interactions, reused from one to the next.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "expressions/formula.h"
#include "interactions/kernels.h"
#include "interactions/neighbour_list.h"
#include "interactions/ties.h"

namespace motes::interactions {

/// A rank's record of tied particles in this step, by row of Bonds.
struct Knots {
  struct Knot {
    float place[3];     // position at interaction `seen`, m
    float at[3];        // position predicted for the end of the step, without ties, m
    float velocity[3];  // m/s
    float inverse;      // 1/mass; 0: pinned
    std::uint32_t torn;  // one bit per bond
    std::uint32_t seen = 0;  // number of the interaction in which this was noted
  };
  std::vector<Knot> knots;
  std::uint32_t meeting = 0;
  float longest = 0;  // longest tie of this rank's particles at the last interaction, m
};

/// Formulas of the last few laws that scripts wrote, and columns for them.
struct ScriptedMemory {
  struct Compiled {
    std::vector<expressions::Expression> values;
    expressions::Formula formula;
  };
  std::vector<Compiled> formulas;
  std::vector<std::uint64_t> ids;  // ids of the other system: own particles, then ghosts
  std::vector<std::vector<float>> copied, column, out;
  std::vector<float> radius;
};

struct Scratch {
  struct Party {
    Cells cells;
    NeighbourList list;
    std::vector<float> at[3], copied_at[3];  // predicted positions at the end of the step
    std::vector<float> column[party_columns];
    std::vector<float> out[kMostResults];
  };
  Party party[2];
  ScriptedMemory scripted;
  std::map<std::pair<std::size_t, TiesKey>, Knots> knots;  // by system
  std::unique_ptr<Scratch> second;

  /// Returns the working memory of one of two systems, 0 or 1, that act one after the other.
  Scratch& of(std::size_t side) {
    if (side == 0) return *this;
    if (second == nullptr) second = std::make_unique<Scratch>();
    return *second;
  }
};

}  // namespace motes::interactions
