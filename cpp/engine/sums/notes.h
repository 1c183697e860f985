// What ranks tell each other while they write particles to files: numbers that add up, and for the manager a note of
// each rank. The particles themselves stay where they are.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/rank.h"

namespace motes::engine {

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
