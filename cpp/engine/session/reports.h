// Merges reports on their way up the tree: each rank adds those of the ranks right below it to its own, so that no rank
// reads more reports than it has children. Loads of calculators follow behind the reports; only the manager reads them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "comm/message.h"
#include "engine/session/rank.h"
#include "engine/session/report.h"
#include "engine/session/round.h"

namespace motes::engine {

/// The merged report of a rank and all ranks below it.
struct Gathered {
  Report report;  // only flows that lead out of this part of the tree
  std::vector<Flow> staying;  // flows within this part of the tree
  std::vector<comm::Message> below;  // keep the bytes of
  std::vector<std::span<const std::byte>> loads;  // the calculators' loads, one entry per child
};

/// The loads of a round's systems on all calculators. Manager.
struct Loads {
  std::vector<CalculatorLoad> rows;  // in the order of the tree
  std::size_t systems = 0;

  const CalculatorLoad& of(const roles::Tree& tree, int calculator, std::size_t system) const {
    return rows[static_cast<std::size_t>(tree.row_of(calculator)) * systems + system];
  }
};

/// The reports of a round at the manager.
struct Judged {
  Tail tail;
  Loads loads;
  std::vector<Strain> strains;  // one per system of the round
};

/// Sends this rank's report of a round: at once if no rank is below it, otherwise with pass_reports() or judge(). All
/// ranks.
void send_report(Rank& rank, const Round& round);

/// Waits for the reports of those right below this rank, and puts them together with its own.
Gathered gather_reports(Rank& rank, Round& round);

/// Sends the merged report up; returns the flows that stay in this part of the tree. All ranks but the manager.
std::vector<Flow> pass_reports(Rank& rank, Round& round);

/// Manager: all loads, once nobody waits for it any more.
Loads loads_of(const Rank& rank, const Round& round, const Gathered& gathered);

/// What only the log needs: of calculators in the order of the tree, and of all ranks.
struct AllTails {
  std::vector<CalculatorTail> calculators;
  std::vector<RankTimes> times;
};

/// Manager: waits for what the log needs of the others besides `own`.
AllTails gather_tails(Rank& rank, comm::Stamp stamp, std::vector<CalculatorTail> own, comm::Spent own_spent);

}  // namespace motes::engine
