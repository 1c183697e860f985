// Sums over the particles of all ranks: each rank adds the sums of its children in the tree to its own, and the total
// is sent down again. Also used when ranks write particles to files: they sum numbers and send notes to the manager.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/rank.h"
#include "program/sums.h"

namespace motes::engine {

/// Returns the total over all ranks, on every rank. Collective, after all ranks have agreed that none failed.
program::Totals total_of_all(Rank& rank, program::Summed own);

/// A rank's input to exchange_notes(): numbers to sum, equally many on all ranks, and bytes for the manager's script.
struct Note {
  std::vector<std::int64_t> numbers;
  std::string text;
};

/// The result of exchange_notes().
struct Notes {
  std::vector<std::int64_t> totals;  // each number summed over all ranks
  std::vector<std::string> texts;    // manager: the text of each rank, in order; empty elsewhere
};

/// Sums the numbers of all ranks, and sends their texts to the manager. Collective, after all ranks have agreed that
/// none failed.
Notes exchange_notes(Rank& rank, Note own);

}  // namespace motes::engine
