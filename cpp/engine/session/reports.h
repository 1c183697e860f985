// Merges reports on their way up the tree: each rank adds its children's reports to its own, so no rank reads more
// reports than it has children. Calculators' loads follow the reports in the messages; only the manager reads them.
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
  Report report;  // with only those flows that leave this subtree
  std::vector<Flow> staying;  // flows within this subtree
  std::vector<comm::Message> below;  // own the bytes of `loads`
  std::vector<std::span<const std::byte>> loads;  // the calculators' loads, one entry per child
};

/// Manager: the loads of a round's systems on all calculators.
struct Loads {
  std::vector<CalculatorLoad> rows;  // in the order of the tree
  std::size_t systems = 0;

  const CalculatorLoad& of(const roles::Tree& tree, int calculator, std::size_t system) const {
    return rows[static_cast<std::size_t>(tree.row_of(calculator)) * systems + system];
  }
};

/// Manager: what remains of a round's reports until they enter the account.
struct Judged {
  Tail tail;
  Loads loads;
  std::vector<Strain> strains;  // one per system of the round
};

/// Sends this rank's report of a round: at once if no rank is below it, otherwise with pass_reports() or judge(). Every
/// rank calls it.
void send_report(Rank& rank, const Round& round);

/// Waits for the children's reports and merges them with this rank's.
Gathered gather_reports(Rank& rank, Round& round);

/// Sends the merged report up; returns the flows within this subtree. Every rank except the manager calls it.
std::vector<Flow> pass_reports(Rank& rank, Round& round);

/// Manager: returns the loads of all calculators; called when no rank waits for the manager.
Loads loads_of(const Rank& rank, const Round& round, const Gathered& gathered);

/// Results that only the log needs: of calculators, in the order of the tree, and of all ranks.
struct AllTails {
  std::vector<CalculatorTail> calculators;
  std::vector<RankTimes> times;
};

/// Manager: waits for the other ranks' tails, and returns them with its own.
AllTails gather_tails(Rank& rank, comm::Stamp stamp, std::vector<CalculatorTail> own, comm::Spent own_spent);

}  // namespace motes::engine
