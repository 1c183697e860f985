// What ranks exchange while writing particles to files: numbers that are summed, and a note of each rank for the
// manager.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/rank.h"

namespace motes::engine {

/// A rank's note: numbers (equally many on every rank), and bytes for the manager's script.
struct Note {
  std::vector<std::int64_t> numbers;
  std::string text;
};

/// What a rank gets back.
struct Notes {
  std::vector<std::int64_t> totals;  // each number, added up over all ranks
  std::vector<std::string> texts;    // manager: of each rank in order; empty elsewhere
};

/// Collective, when all ranks have agreed that none of them failed.
Notes exchange_notes(Rank& rank, Note own);

}  // namespace motes::engine
