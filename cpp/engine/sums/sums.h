// Sums over the particles of all ranks: each rank on the way up the tree adds what those below it have, and the result
// goes down again. While ranks write particles to files, they tell each other numbers that add up, and the manager a
// note of each; the particles themselves stay where they are.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/rank.h"
#include "program/sums.h"

namespace motes::engine {

/// Collective, when all ranks have agreed that none of them failed: what all of them have, on every rank.
program::Totals total_of_all(Rank& rank, program::Summed own);

/// What a rank tells: as many numbers on every rank, and bytes that only the manager's script understands.
struct Note {
  std::vector<std::int64_t> numbers;
  std::string text;
};

/// What a rank learns.
struct Notes {
  std::vector<std::int64_t> totals;  // each number, added up over all ranks
  std::vector<std::string> texts;    // manager: of each rank in order; empty elsewhere
};

/// Collective, when all ranks have agreed that none of them failed.
Notes exchange_notes(Rank& rank, Note own);

}  // namespace motes::engine
